"""Samples: their ground truth against trimesh, alone and with neighbours, and what fails."""

import io
import json
import tarfile

import numpy as np
import pytest
import trimesh

from datasets_gen import InputError, load
from evaluation.generation import TrainingSample, make_sample, read_shard
from evaluation.generation.sample_making import FailedSample, samples_of
from evaluation.generation.sample_plan import SamplePlan, outlines


@pytest.fixture
def made(tiny, blobs):
    """Makes samples of a configuration, without its validation split."""
    body = load(blobs)

    def make(count=12, first=0, **changes):
        config = tiny(validation=0.0, **changes)
        plan = SamplePlan(config, outlines(config))
        return plan, list(samples_of(plan, "train", first, count, lambda _: body)), body

    return make


def surface_points(mesh, sample):
    return trimesh.triangles.barycentric_to_points(mesh.triangles[sample.face_ids], sample.barycentrics)


def test_truth_on_the_reference_and_on_the_pose(made, blobs):
    """Against the mesh files, by trimesh: the canonical place, and the place that was hit."""
    meshes = {pose: trimesh.load(blobs / f"{pose}.ply", process=False) for pose in ("rest", "bent", "curled")}
    _, samples, _ = made()
    assert {each.about["pose"] for each in samples} == set(meshes)
    for each in samples:
        assert each.about["reference"] == "rest"
        np.testing.assert_allclose(surface_points(meshes["rest"], each), each.canonical, atol=2e-6)
        np.testing.assert_allclose(
            surface_points(meshes[each.about["pose"]], each), each.true_points, atol=2e-6
        )
        assert np.linalg.norm(each.points - each.true_points, axis=1).max() < 0.05
        assert np.abs(np.linalg.norm(each.normals, axis=1) - 1).max() < 1e-5
        assert each.intensity.min() >= each.about["threshold"] - 1e-6
        assert set(each.view_ids) <= {0, 1, 2}


def test_two_samples_of_one_body_correspond_by_their_canonical_places(made, blobs):
    """The nearest canonical place leads to the true place in the other pose, within the spacing."""
    _, samples, _ = made(scan={"points": 2000, "views": 6, "scanner": {"resolution": [120, 120]}})
    one = samples[0]
    other = next(each for each in samples if each.about["pose"] != one.about["pose"])
    other_mesh = trimesh.load(blobs / f"{other.about['pose']}.ply", process=False)
    apart = np.linalg.norm(one.canonical[:, None] - other.canonical[None], axis=2)
    nearest, gap = apart.argmin(axis=1), apart.min(axis=1)
    where = surface_points(other_mesh, one)  # of one's points, in the pose of the other
    error = np.linalg.norm(other.true_points[nearest] - where, axis=1)
    seen = gap < 0.05
    assert seen.mean() > 0.3
    assert error[seen].max() < 2 * 0.05


def test_the_share_that_is_missing_grows_with_the_threshold(made):
    _, samples, _ = made(draw={"threshold": [0.1, 0.9], "per_render": 6}, count=6)
    by_threshold = sorted(samples, key=lambda each: each.about["threshold"])
    missing = [each.about["missing"] for each in by_threshold]
    assert missing == sorted(missing)
    assert missing[0] < missing[-1]


def test_a_sample_made_alone_is_the_same(made):
    plan, samples, body = made()
    for index in (7, 2):
        alone = make_sample(plan, "train", index, lambda _: body)
        assert alone.members() == samples[index].members()


def test_what_is_written_is_read_back(made, tmp_path):
    _, samples, _ = made(count=3)
    with tarfile.open(tmp_path / "x.tar", "w") as archive:
        for each in samples:
            each.write(archive)
    for before, after in zip(samples, read_shard(tmp_path / "x.tar"), strict=True):
        assert after.key == before.key
        assert after.about == json.loads(json.dumps(before.about))
        assert after.members() == before.members()
        assert (after.points.dtype, after.face_ids.dtype) == (np.float32, np.int32)


def test_members_are_plain_arrays_without_time_and_owner(made, tmp_path):
    _, (sample, *_), _ = made(count=1)
    with tarfile.open(tmp_path / "x.tar", "w") as archive:
        sample.write(archive)
    with tarfile.open(tmp_path / "x.tar") as archive:
        entries = archive.getmembers()
        points = np.load(io.BytesIO(archive.extractfile("train-00000000.points.npy").read()))
    np.testing.assert_array_equal(points, sample.points)
    assert {(e.mtime, e.uid, e.gid, e.uname, e.gname, e.mode) for e in entries} == {(0, 0, 0, "", "", 0o644)}
    assert {entry.name.partition(".")[0] for entry in entries} == {"train-00000000"}


def test_a_render_that_fails_takes_its_samples_with_it_and_no_others(made):
    dark = {"scanner.exposure": [1.0, 1e-9]}
    _, samples, _ = made(draw={"threshold": [0.2, 0.7], "per_render": 2, "sweep": dark}, count=16)
    failed = [each for each in samples if isinstance(each, FailedSample)]
    assert 0 < len(failed) < 16
    assert [type(samples[i]) for i in range(0, 16, 2)] == [type(samples[i]) for i in range(1, 16, 2)]
    assert all(each.refused and "blob" in each.reason and "\n" not in each.reason for each in failed)
    assert [
        each.identity.index if isinstance(each, FailedSample) else each.about["index"] for each in samples
    ] == [*range(16)]


def test_thresholds_that_hardly_a_point_reaches_fail_alone(made):
    plan, samples, body = made(draw={"threshold": [0.3, 1.0], "per_render": 20}, count=20)
    failed = [each for each in samples if isinstance(each, FailedSample)]
    assert 0 < len(failed) < 10
    assert all("peak threshold" in each.reason and each.refused for each in failed)
    with pytest.raises(InputError, match=r"cannot be made.*peak threshold"):
        make_sample(plan, "train", failed[0].identity.index, lambda _: body)


def test_unexpected_failures_are_worth_another_try(tiny):
    config = tiny()
    plan = SamplePlan(config, outlines(config))

    def broken(_):
        raise MemoryError

    (failed,) = samples_of(plan, "train", 0, 1, broken)
    assert not failed.refused
    assert "MemoryError" in failed.reason


def test_a_mesh_is_sampled_as_it_is(made):
    _, samples, body = made(scan={"points": 100, "views": "surface"}, count=3)
    for each in samples:
        assert (each.about["threshold"], each.about["missing"]) == (None, 0.0)
        assert set(each.view_ids) == {-1}
        on_pose = body[each.about["pose"]].at(each.face_ids, each.barycentrics.astype(float))
        np.testing.assert_allclose(on_pose, each.points, atol=2e-6)


def test_clouds_are_turned_and_scaled_and_canonical_places_stay(made):
    _, (before, *_), _ = made(count=1)
    changed = {"points": 120, "views": 3, "scanner": {"resolution": [60, 60], "stripes": 120}}
    _, (after, *_), _ = made(count=1, scan={**changed, "rotation": 90.0, "scale": 10.0})
    np.testing.assert_array_equal(before.canonical, after.canonical)
    gaps = [np.linalg.norm(np.diff(each.points.astype(float), axis=0), axis=1) for each in (before, after)]
    np.testing.assert_allclose(gaps[1], 10 * gaps[0], rtol=1e-4, atol=1e-4)
    assert np.abs(after.points - 10 * before.points).max() > 1


@pytest.mark.parametrize("missing", ["points.npy", "json"])
def test_samples_that_lack_a_file_are_refused(made, missing):
    _, (sample, *_), _ = made(count=1)
    members = sample.members()
    del members[missing]
    with pytest.raises(InputError, match="train-00000000"):
        TrainingSample.of_members(sample.key, members)
