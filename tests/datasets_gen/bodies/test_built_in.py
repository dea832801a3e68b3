"""Options of the built-in bodies: subjects, mesh noise and what is held out."""

from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

from datasets_gen import InputError, check_mesh, load, mirror_map, write_collection
from datasets_gen.bodies.built_in import BODIES
from datasets_gen.checks import signed_volume
from datasets_gen.meshes.soundness import crossing_faces, edge_stretch
from datasets_gen.registry import HELD_OUT, held_out, outline, provenance
from tests.benchmarks.match_evidence import check_not_held_out

ARTICULATED = [name for name, recipe in BODIES.items() if recipe.regions is not None]


def test_subjects_share_the_mesh_and_the_first_is_the_body_itself():
    alone, two = load("torus", poses=["round", "folded"]), load("torus", subjects=2, variation=0.1)
    assert two.subject == "torus-2subjects-variation0.1"
    assert two.poses[:2] == ("1-round", "1-squeezed")
    assert len(two) == 2 * len(load("torus"))
    assert two.reference is two.shapes[0]
    for pose in alone.poses:
        assert np.array_equal(two[f"1-{pose}"].vertices, alone[pose].vertices)
        assert two[f"2-{pose}"].vertices[:, 0] != pytest.approx(alone[pose].vertices[:, 0], abs=0.01)


def test_truth_across_subjects_is_a_point_of_the_reference():
    body = load("thin_sheet", subjects=2)
    faces, weights = np.array([0, 100, 2000]), np.full((3, 3), 1 / 3)
    assert body.canonical(body["2-roll"], faces, weights) == pytest.approx(body.reference.at(faces, weights))


def test_options_decide_the_subject_and_are_told_before_anything_is_built():
    options = {"seed": 3, "subjects": 2, "variation": 0.2, "mesh_noise": 0.1, "poses": ["2-walk", "1-rest"]}
    told = outline("human", **options)
    assert told == {
        "subject": "human-3-2subjects-variation0.2-noise0.1",
        "poses": ["2-walk", "1-rest"],
        "reference": "1-rest",
    }


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"subjects": 0}, "subjects of 'torus' is 0; give a whole number of at least 1"),
        ({"subjects": 1.5}, "subjects of 'torus' is 1.5"),
        ({"subjects": 101}, "subjects of 'torus' is 101; give at most 100"),
        ({"variation": 0.5}, r"variation of 'torus' is 0.5; give a number from 0 to 0.3"),
        ({"variation": -0.1}, "variation of 'torus' is -0.1"),
        ({"variation": "much"}, "option variation must be a finite number, got 'much'"),
        ({"mesh_noise": 0.41}, "mesh_noise of 'torus' is 0.41; give a number from 0 to 0.4"),
        ({"mesh_noise": float("nan")}, "option mesh_noise must be a finite number"),
        ({"subjects": 2, "poses": ["round"]}, "no pose 'round'; it has .*'1-round'"),
    ],
)
def test_wrong_options(options, reason):
    for function in (load, outline):
        with pytest.raises(InputError, match=reason):
            function("torus", **options)


@pytest.mark.parametrize("name", ["thin_sheet", "human"])
def test_mesh_noise_moves_along_the_surface_and_keeps_the_truth(name):
    plain, noisy = load(name), load(name, mesh_noise=0.3)
    assert noisy.poses == plain.poses
    assert noisy.subject == f"{name}-noise0.3"
    edge = np.sqrt(plain.reference.face_areas.mean() * 4 / np.sqrt(3))
    for pose in plain.poses[:3]:
        a, b = plain[pose], noisy[pose]
        assert check_mesh(b) == ()
        assert 0.05 * edge < np.median(cKDTree(a.vertices).query(b.vertices)[0]) < 0.3 * edge
        assert signed_volume(b.vertices, b.faces) == pytest.approx(
            signed_volume(a.vertices, a.faces), rel=0.01
        )
    nearest = cKDTree(plain.reference.vertices).query(noisy.reference.vertices)[1]
    other = plain.shapes[2].vertices[nearest]
    assert np.linalg.norm(noisy.shapes[2].vertices - other, axis=1).max() < 1.5 * edge
    assert abs(np.corrcoef(nearest, np.arange(len(nearest)))[0, 1]) < 0.05


def test_mesh_noise_is_seeded():
    first, second, other = (
        load("torus", mesh_noise=0.2),
        load("torus", mesh_noise=0.2),
        load("torus", mesh_noise=0.1),
    )
    assert np.array_equal(first["folded"].vertices, second["folded"].vertices)
    assert not np.array_equal(first["folded"].vertices, other["folded"].vertices)


def test_the_mirror_map_is_numbered_anew_with_the_vertices():
    plain, noisy = load("human"), load("human", mesh_noise=0.2)
    v = noisy.reference.vertices
    assert np.array_equal(noisy.mirror[noisy.mirror], np.arange(len(v)))
    assert np.linalg.norm(v[noisy.mirror] - v * [-1, 1, 1], axis=1).max() < 0.02
    assert np.array_equal(mirror_map(plain.reference), plain.mirror)


def test_held_out_are_families_seeds_and_poses():
    assert HELD_OUT == ("hand", "bird", "octopus")
    assert all(held_out(name) for name in HELD_OUT)
    assert not any(held_out(name) for name in ("human", "human_asymmetric", "quadruped", "torus"))
    assert held_out("human", seed=100)
    assert not held_out("human", seed=99, poses=["walk"])
    assert held_out("human", poses=["walk", "climb"])
    assert held_out("quadruped", subjects=2, poses=["1-stand", "2-canter"])


@pytest.mark.parametrize(
    ("name", "kept"), [("human", {"kneel", "throw", "climb"}), ("quadruped", {"paw", "canter"})]
)
def test_held_out_poses_are_given_only_by_name(name, kept):
    assert not kept & {*load(name).poses}
    assert {*load(name, poses=sorted(kept)).poses} == kept
    assert {*outline(name, poses=sorted(kept))["poses"]} == kept


def test_weights_are_not_fitted_to_what_is_held_out(tmp_path):
    write_collection(load("torus"), tmp_path / "kept", provenance("hand"))
    write_collection(load("torus"), tmp_path / "free", provenance("torus"))
    check_not_held_out(["human", "quadruped", str(tmp_path / "free")])
    for name in ("octopus", str(tmp_path / "kept")):
        with pytest.raises(InputError, match="is held out: no weight may be fitted to it"):
            check_not_held_out(["human", name])


def test_the_preset_of_held_out_shapes_has_nothing_else():
    import tomllib

    text = (Path(__file__).parents[3] / "evaluation" / "protocols" / "heldout.toml").read_text()
    sections = tomllib.loads(text)["dataset"]
    assert {each["name"] for each in sections} >= {*HELD_OUT}
    assert all(held_out(each["name"], **each.get("options", {})) for each in sections)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("name", ARTICULATED)
def test_subjects_of_articulated_bodies_are_sound(name):
    body = load(name, subjects=2, variation=0.1)
    rest = body[body.poses[len(body) // 2]]
    assert rest.pose.startswith("2-")
    volume = signed_volume(body.reference.vertices, body.reference.faces)
    assert 0.02 < abs(signed_volume(rest.vertices, rest.faces) / volume - 1) < 0.35
    stretch = edge_stretch(rest, body.reference)
    assert 0.8 < stretch.low < stretch.high < 1.25
    assert stretch.high - stretch.low > 0.05
    for shape in body.shapes:
        assert check_mesh(shape) == ()
        assert crossing_faces(shape).mean() < 0.01, shape.name
    if body.mirror is not None:
        v = rest.vertices
        assert v[body.mirror] == pytest.approx(v * [-1, 1, 1], abs=1e-6)
