"""Errors in one call are refused on a mesh that is not the one that was scanned."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh
from scipy.spatial import cKDTree

import medialbench as mb
from datasets_gen import InputError
from evaluation.methods import dense
from scanner_sim import sample
from tests.reports.conftest import collection


def shuffled(shape):
    return replace(shape, faces=np.random.default_rng(0).permutation(shape.faces))


def rolled(shape):
    """The same surface; each face begins at another of its corners."""
    return replace(shape, faces=np.roll(shape.faces, 1, axis=1))


def reversed_vertices(shape):
    return replace(shape, vertices=shape.vertices[::-1].copy())


def flattened(shape):
    return replace(shape, vertices=shape.vertices * [1, 1, 0.01])


@pytest.fixture(scope="module")
def body():
    return collection()


@pytest.fixture(scope="module")
def scans(body):
    return sample(body["rest"], 300, seed=1), sample(body["bent"], 300, seed=2)


@pytest.fixture(scope="module")
def found():
    return dense(np.arange(300), np.ones(300))


@pytest.mark.parametrize("change", [shuffled, rolled, reversed_vertices, flattened])
def test_another_mesh_of_the_same_name_is_refused(change, body, scans, found):
    other = change(body["rest"])
    for measure in (mb.geodesic_error, mb.score):
        with pytest.raises(InputError, match="a scan of 'blob/rest', but not of the one given"):
            measure(found, *scans, other)
    with pytest.raises(InputError, match="not of the one given"):
        mb.diffusion_error(scans[0], other, modes=20)


def test_faces_in_another_order_are_noticed_on_another_pose(body, scans, found):
    rest = replace(body["rest"], name="blob/other", pose="other")
    with pytest.raises(InputError, match="points keep their neighbours"):
        mb.geodesic_error(found, *scans, shuffled(rest))


def test_a_pose_may_be_turned_and_in_another_unit(body, scans, found):
    expected = mb.geodesic_error(found, *scans, body["rest"])
    turned = replace(body["rest"], vertices=1000 * body["rest"].vertices[:, [1, 2, 0]] + 7)
    np.testing.assert_allclose(mb.geodesic_error(found, *scans, turned), expected, rtol=1e-6)
    assert np.isfinite(mb.geodesic_error(found, *scans, body)).all()


def test_poses_with_a_mesh_of_their_own_lie_on_the_reference(tmp_path):
    """A set of two meshes whose vertices correspond by a file: the same surface, faces in another order."""
    ball = trimesh.creation.icosphere(subdivisions=3)
    order = np.random.default_rng(0).permutation(len(ball.vertices))
    faces = np.argsort(order)[ball.faces][::-1]
    for name in ("shapes", "maps"):
        (tmp_path / name).mkdir()
    vertices = ball.vertices * [1, 1.4, 2]
    trimesh.Trimesh(vertices, ball.faces, process=False).export(tmp_path / "shapes" / "B.off")
    trimesh.Trimesh(vertices[order], faces, process=False).export(tmp_path / "shapes" / "A.off")
    np.savetxt(tmp_path / "maps" / "A_B.map", order, fmt="%d")
    body = mb.load(tmp_path, reference="B")
    a, b = mb.sample(body["A"], 300, seed=1), mb.sample(body["B"], 300, seed=2)
    nearest = cKDTree(b.true_points).query(a.true_points)[1]
    found = dense(nearest, np.ones(300))
    told = mb.score(found, a, b, body)
    assert mb.geodesic_error(found, a, b, body).mean() == pytest.approx(100 * told.counted.mean())
    assert told.counted.mean() < 1.1 * told.least  # the nearest point is the best there is


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"source_to_target": list(range(300))}, "without a column of integer ids"),
        ({"source_to_target": np.arange(300)[:, None]}, "without a column of integer ids"),
        ({"confidence": np.full(300, np.nan)}, r"a confidence in \[0, 1\]"),
        ({"confidence": np.full(300, 2.0)}, r"a confidence in \[0, 1\]"),
    ],
)
def test_maps_whose_fields_were_replaced_are_refused(change, message, body, scans, found):
    with pytest.raises(InputError, match=message):
        mb.score(replace(found, **change), *scans, body)


def test_a_score_is_shown_in_a_line(body, scans, found):
    told = mb.score(found, *scans, body)
    assert repr(told).startswith(f"MapScore(300 points, mean {100 * told.counted.mean():.2f}, least ")
    assert len(repr(told)) < 80
