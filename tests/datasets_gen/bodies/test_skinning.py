import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from datasets_gen.bodies.implicit_surface import Body, sweep
from datasets_gen.bodies.skeleton import Skeleton, hinge
from datasets_gen.bodies.skinning import DeltaMush, bone_of, diffused_weights, dual_quaternion_skinning
from tests.datasets_gen.sample_meshes import sphere

BALL = sphere(3)
VERTICES, FACES = BALL.vertices * [0.3, 1.0, 0.3], BALL.faces.astype(np.int64)
SKELETON = Skeleton(
    (
        hinge("low", None, (0, -0.9, 0), (0, 0, 0), (1, 0, 0)),
        hinge("high", "low", (0, 0, 0), (0, 0.9, 0), (1, 0, 0)),
    )
)
BODY = Body(
    (
        sweep(
            "low high", (0, -0.9, 0), (0, 0.9, 0), [(0, 0.2, 0.2), (1, 0.2, 0.2)], caps=(0.1, 0.1), blend=0.02
        ),
    )
)

rotations = st.tuples(*[st.floats(-3, 3)] * 3).map(lambda v: Rotation.from_rotvec(v).as_matrix())
shifts = st.tuples(*[st.floats(-2, 2)] * 3).map(np.array)


def weights(stiffness=0.5):
    return diffused_weights(VERTICES, FACES, bone_of(VERTICES, BODY, SKELETON), SKELETON, stiffness)


def test_vertices_belong_to_the_nearer_bone():
    owner = bone_of(VERTICES, BODY, SKELETON)
    assert (owner[VERTICES[:, 1] > 0.05] == 1).all()
    assert (owner[VERTICES[:, 1] < -0.05] == 0).all()


def test_weights_are_a_smooth_partition_of_unity():
    w = weights()
    assert w.sum(axis=1) == pytest.approx(1)
    assert w.min() >= 0
    assert w[VERTICES[:, 1] > 0.8, 1].min() > 0.9
    belt = np.abs(VERTICES[:, 1]) < 0.02
    assert w[belt, 1] == pytest.approx(0.5, abs=0.1)


def test_stiffness_bounds_how_far_a_bone_reaches():
    reach = [
        weights(s)[(VERTICES[:, 1] > 0.15) & (VERTICES[:, 1] < 0.4), 0].mean() for s in (0.5, 0.15, 0.05)
    ]
    assert reach[0] > reach[1] > reach[2]


@settings(max_examples=25, deadline=None)
@given(rotations, shifts)
def test_a_common_rigid_motion_is_reproduced(turn, shift):
    posed = dual_quaternion_skinning(VERTICES, weights(), np.stack([turn, turn]), np.stack([shift, shift]))
    assert posed == pytest.approx(VERTICES @ turn.T + shift, abs=1e-9)


def test_full_weight_follows_its_bone_alone():
    turns, moves = SKELETON.transforms({"high": (80, 20, 10)})
    w = np.zeros((len(VERTICES), 2))
    w[:, 1] = 1
    assert dual_quaternion_skinning(VERTICES, w, turns, moves) == pytest.approx(
        VERTICES @ turns[1].T + moves[1]
    )


def test_half_weights_of_a_twist_turn_half_way_without_shrinking():
    turns, moves = SKELETON.transforms({"high": (0, 120, 0)})
    ring = np.array([[0.3, 0, 0], [0, 0, 0.3]])
    posed = dual_quaternion_skinning(ring, np.full((2, 2), 0.5), turns, moves)
    half = Rotation.from_rotvec(np.radians([0, 60, 0])).apply(ring)
    assert posed == pytest.approx(half)  # linear blending would give half the radius


@settings(max_examples=10, deadline=None)
@given(rotations, shifts)
def test_delta_mush_keeps_rigidly_moved_skin(turn, shift):
    mush = DeltaMush.of_rest(VERTICES, FACES, steps=8)
    moved = VERTICES @ turn.T + shift
    assert mush(moved) == pytest.approx(moved, abs=1e-9)


def test_delta_mush_relaxes_a_spike_that_the_rest_pose_lacks():
    mush = DeltaMush.of_rest(VERTICES, FACES, steps=8)
    spiked = VERTICES.copy()
    spiked[10] *= 1.5
    assert (
        np.linalg.norm(mush(spiked) - VERTICES, axis=1).max()
        < 0.3 * np.linalg.norm(spiked - VERTICES, axis=1).max()
    )
