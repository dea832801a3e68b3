"""The built-in bodies as their users see them."""

import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from datasets_gen import check_mesh, load, load_folder, mirror_map, write_collection
from datasets_gen.bodies.body_plan import BodyPlan, build_body
from datasets_gen.bodies.built_in import BODIES
from datasets_gen.checks import edge_face_counts, signed_volume
from datasets_gen.meshes.soundness import crossing_faces, edge_stretch
from tests.datasets_gen.meshes.test_remeshing import smallest_angles
from tests.datasets_gen.overlap import buried_fraction

POSES = {
    "human": {"rest", "tpose", "arms_up", "walk", "run", "sit", "crouch", "bend", "twist", "lunge"},
    "quadruped": {
        "stand", "walk", "trot", "gallop_extended", "gallop_collected", "graze", "rear", "turn_head",
    },
    "hand": {"rest", "fist", "spread", "point", "victory", "pinch", "thumb_up"},
    "bird": {"stand", "walk", "run", "peck", "look_back", "display", "one_leg"},
    "octopus": {"rest", "curl", "pinwheel", "stride", "reach", "swim"},
    "capsule_chain": {"straight", "arc", "s_bend", "helix", "stretched"},
    "dumbbell": {"straight", "arc", "s_bend", "stretched"},
    "thin_sheet": {"flat", "roll", "wave", "fold", "roll_askew"},
    "torus": {"round", "squeezed", "saddle", "folded"},
}  # fmt: skip
POSES["human_asymmetric"] = POSES["human"]
FLIP = np.array([-1.0, 1, 1])
TO_BUILD = ("hand", "bird", "octopus", "capsule_chain", "dumbbell")
"""Take another minute; the others are built by the rest of the default tests, too, or at once."""
GRIDS = ("thin_sheet", "torus")
HARDLY = {"human": 0.005, "human_asymmetric": 0.005, "quadruped": 0.005, "hand": 0.0002, "bird": 0.001}
"""Share of the faces by which poses may cut themselves. They stay as they are, as published numbers rest on
them: two faces at a bent finger's root, thirteen of a bird that stands on one leg."""

bodies = pytest.mark.parametrize(
    "name",
    [pytest.param(n, marks=[pytest.mark.slow, pytest.mark.long] if n in TO_BUILD else []) for n in BODIES],
)
articulated = [name for name, recipe in BODIES.items() if recipe.regions is not None]


def all_poses(name):
    """The body in all poses, held-out ones among them."""
    plan = BODIES[name].plan(0)
    return load(name, poses=[*plan.poses, *plan.held_out])


@pytest.mark.parametrize("name", articulated)
def test_poses_are_within_the_limits_of_the_joints(name):
    plan = BODIES[name].plan(3)
    assert len(plan.poses) >= 6
    beyond = {pose: plan.skeleton.beyond_limits(a) for pose, a in {**plan.poses, **plan.held_out}.items()}
    assert {pose: lines for pose, lines in beyond.items() if lines} == {}
    bones = {bone.name.removesuffix(".L").removesuffix(".R") for bone in plan.skeleton.bones}
    assert {*plan.skeleton.limits} <= bones
    assert all(low <= 0 <= high for ranges in plan.skeleton.limits.values() for low, high in ranges)


@bodies
def test_rest_pose_is_a_well_shaped_closed_surface_in_one_piece(name):
    rest = load(name).reference
    assert check_mesh(rest) == ()
    assert 8_000 <= len(rest.vertices) <= 15_000
    counts = edge_face_counts(rest.faces)
    assert (counts == 2).all()
    genus = 1 if name == "torus" else 0
    assert len(rest.vertices) - len(counts) + len(rest.faces) == 2 - 2 * genus
    assert rest.units == "m"
    if name in GRIDS:
        return
    angles = smallest_angles(rest.vertices, rest.faces)
    assert angles.min() > 10
    assert np.quantile(angles, 0.01) > 30
    assert np.bincount(rest.faces.ravel()).max() <= 12


@pytest.mark.slow
@bodies
def test_poses_are_sound_and_keep_volume_area_and_lengths(name):
    body = load(name)
    rest = body.reference
    assert POSES[name] <= {s.pose for s in body.shapes}
    assert body.shapes[0] is rest
    volume = signed_volume(rest.vertices, rest.faces)
    for shape in body.shapes:
        assert shape.faces is rest.faces or np.array_equal(shape.faces, rest.faces)
        assert check_mesh(shape) == ()
        assert shape.vertices[:, 1].min() == pytest.approx(0)  # stands on the ground
        assert 0.90 < signed_volume(shape.vertices, shape.faces) / volume < 1.10
        assert 0.93 < shape.area / rest.area < 1.10
        stretch = edge_stretch(shape, rest)
        assert 0.45 < stretch.low <= 1 <= stretch.high < 2.2
        assert 0 < stretch.shortest <= stretch.longest < 4


@bodies
def test_poses_differ_from_one_another(name):
    """Apart from where they stand, by at least a joint's worth of motion."""
    body = all_poses(name)
    shapes, least = body.shapes, 0.065 * body.reference.diagonal
    for i, first in enumerate(shapes):
        for second in shapes[:i]:
            a, b = (s.vertices - s.vertices.mean(axis=0) for s in (first, second))
            assert np.linalg.norm(a - b, axis=1).max() > least


@pytest.mark.slow
@bodies
def test_poses_hardly_cut_themselves(name):
    """Most not at all."""
    body = all_poses(name)
    for shape in body.shapes:
        most = HARDLY.get(name, 0) if shape.pose != body.reference.pose else 0
        assert crossing_faces(shape).mean() <= most, shape.name


@pytest.mark.long
@pytest.mark.slow
@bodies
def test_poses_are_not_inside_themselves(name):
    for shape in load(name).shapes:
        assert buried_fraction(shape) <= 0.01, shape.name


def test_buried_fraction_sees_an_overlap():
    """Two spheres that share a lens: known share of buried area."""
    from tests.datasets_gen.sample_meshes import shape, sphere

    ball, gap = sphere(3), 1.2
    vertices = np.concatenate([ball.vertices, ball.vertices + np.array([gap, 0, 0])])
    pair = shape(vertices, np.concatenate([ball.faces, ball.faces + len(ball.vertices)]))
    assert buried_fraction(pair, samples=1500) == pytest.approx((1 - gap / 2) / 2, abs=0.04)
    assert buried_fraction(ball) == 0


@pytest.mark.parametrize("name", ["human", "quadruped"])
def test_mirror_map_is_exact(name):
    body = load(name)
    everyone = np.arange(len(body.mirror))
    assert np.array_equal(body.mirror[body.mirror], everyone)
    assert body.reference.vertices[body.mirror] == pytest.approx(body.reference.vertices * FLIP, abs=1e-12)
    mapped = np.sort(body.mirror[body.reference.faces], axis=1)
    assert {tuple(f) for f in mapped} == {tuple(f) for f in np.sort(body.reference.faces, axis=1)}
    assert np.array_equal(mirror_map(body.reference), body.mirror)


def test_asymmetric_human_has_no_mirror_map():
    body = load("human_asymmetric")
    assert body.mirror is None
    assert mirror_map(body.reference) is None
    x = body.reference.vertices[:, 0]
    assert x.max() > -x.min() + 0.03  # one arm is shorter


@pytest.mark.parametrize("name", ["human", "quadruped"])
def test_front_differs_from_back_and_feet_point_forward(name):
    v = load(name).reference.vertices
    feet = v[v[:, 1] < 0.05]
    ankles = v[(v[:, 1] > 0.15) & (v[:, 1] < 0.20)]
    for side in (1, -1):
        foot, ankle = feet[feet[:, 0] * side > 0], ankles[ankles[:, 0] * side > 0]
        assert foot[:, 2].max() > ankle[:, 2].max() + 0.02
    head = v[v[:, 1] > 0.88 * v[:, 1].max()]
    assert head[:, 2].max() > 0.09


def test_proportions_are_those_of_their_kinds():
    human, horse = (np.ptp(load(n).reference.vertices, axis=0) for n in ("human", "quadruped"))
    assert human[1] == pytest.approx(1.75, abs=0.03)
    assert human[0] > 1.2  # arms away from the body
    assert horse[2] > 1.5
    assert 1.8 < horse[1] < 2.3
    assert horse[2] > 3 * horse[0]


def test_written_body_is_read_back(tmp_path):
    body = load("human", poses=["walk", "sit"])
    write_collection(body, tmp_path)
    found = load_folder(tmp_path)
    assert found.subject == "human"
    assert found.reference.pose == "rest"
    assert {s.pose for s in found.shapes} == {"rest", "walk", "sit"}
    assert np.array_equal(found["walk"].faces, body["walk"].faces)
    assert found["walk"].vertices == pytest.approx(body["walk"].vertices, abs=1e-6)
    assert np.array_equal(found.mirror, body.mirror)


def test_canonical_points_follow_the_surface():
    body = load("quadruped")
    rng = np.random.default_rng(0)
    faces = rng.integers(len(body.reference.faces), size=50)
    weights = rng.dirichlet([1, 1, 1], size=50)
    assert body.canonical(body["walk"], faces, weights) == pytest.approx(body.reference.at(faces, weights))


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("name", articulated)
@pytest.mark.parametrize("seed", [1])
def test_other_seeds_give_other_sound_bodies(name, seed):
    default, body = load(name).reference, build_body(BODIES[name].plan(seed))
    rest = body.reference
    assert 8_000 <= len(rest.vertices) <= 15_000
    assert len(rest.vertices) - len(edge_face_counts(rest.faces)) + len(rest.faces) == 2
    assert (
        abs(signed_volume(rest.vertices, rest.faces) / signed_volume(default.vertices, default.faces) - 1)
        > 0.005
    )
    for shape in body.shapes:
        assert check_mesh(shape) == ()
        assert crossing_faces(shape).mean() < 0.01


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("name", articulated)
def test_building_again_gives_the_same_body_whatever_the_blas_threads(name):
    first, plan = load(name), BODIES[name].plan(0)
    assert isinstance(plan, BodyPlan)
    with threadpool_limits(2):
        second = build_body(plan)
    assert np.array_equal(first.reference.faces, second.reference.faces)
    for a, b in zip(first.shapes, second.shapes, strict=True):
        assert np.array_equal(a.vertices, b.vertices)


@pytest.mark.long
@pytest.mark.slow
def test_a_hand_is_not_its_own_mirror_image_and_a_bird_is():
    assert mirror_map(load("hand").reference) is None
    assert mirror_map(load("octopus").reference) is None
    bird = load("bird")
    assert np.array_equal(mirror_map(bird.reference), bird.mirror)
