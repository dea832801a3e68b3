import numpy as np
import pytest

from datasets_gen.bodies.human import skeleton as human_skeleton
from datasets_gen.bodies.quadruped import skeleton as horse_skeleton
from datasets_gen.bodies.skeleton import Skeleton, ball, hinge, other_side, segment_distance

ARM = Skeleton(
    (
        hinge("upper", None, (0, 0, 0), (1, 0, 0), (0, 0, 1)),
        hinge("lower", "upper", (1, 0, 0), (2, 0, 0), (0, 0, 1)),
    )
)


def moved(skeleton, pose, name, point):
    turns, shifts = skeleton.transforms(pose)
    i = skeleton.index(name)
    return turns[i] @ np.asarray(point, dtype=float) + shifts[i]


def test_rest_moves_nothing():
    turns, shifts = ARM.transforms({})
    assert turns == pytest.approx(np.stack([np.eye(3)] * 2))
    assert shifts == pytest.approx(0)


def test_children_follow_and_turn_about_their_own_joint():
    pose = {"upper": (90, 0, 0), "lower": (90, 0, 0)}
    assert moved(ARM, pose, "upper", (1, 0, 0)) == pytest.approx((0, 1, 0))
    assert moved(ARM, pose, "lower", (1, 0, 0)) == pytest.approx((0, 1, 0))
    assert moved(ARM, pose, "lower", (2, 0, 0)) == pytest.approx((-1, 1, 0))


def test_twist_leaves_the_bone_in_place():
    pose = {"upper": (0, 70, 0)}
    assert moved(ARM, pose, "upper", (1, 0, 0)) == pytest.approx((1, 0, 0))
    turned = moved(ARM, pose, "upper", (0, 1, 0))
    assert turned == pytest.approx((0, np.cos(np.radians(70)), np.sin(np.radians(70))))


def test_unknown_bones_are_named():
    with pytest.raises(KeyError, match="tentacle"):
        ARM.transforms({"tentacle": (1, 0, 0)})


def test_angles_beyond_the_limits_of_a_joint_are_told():
    limits = {"forearm": ((0, 145), (0, 0), (-5, 5))}
    bones = (
        hinge("trunk", None, (0, 0, 0), (0, 1, 0), (1, 0, 0)),
        hinge("forearm.L", "trunk", (0, 1, 0), (1, 1, 0), (0, 0, 1)),
        hinge("hand.L", "forearm.L", (1, 1, 0), (2, 1, 0), (0, 0, 1)),
    )
    skeleton = Skeleton(bones, limits)
    assert skeleton.beyond_limits({"forearm.L": (145, 0, -5), "trunk": (500, 9, 9)}) == []
    assert skeleton.beyond_limits({"forearm.L": (-1, 0, 6), "hand.L": (3, 0, 0)}) == [
        "flexion of forearm.L is -1, allowed are 0 to 145 degrees",
        "swing of forearm.L is 6, allowed are -5 to 5 degrees",
        "flexion of hand.L is 3, allowed are 0 to 0 degrees",
    ]


@pytest.mark.parametrize("skeleton", [human_skeleton(), horse_skeleton()])
def test_equal_angles_on_both_sides_are_mirror_images(skeleton):
    flip = np.diag([-1.0, 1, 1])
    rng = np.random.default_rng(0)
    for bone in skeleton.bones:
        if not bone.name.endswith(".L"):
            continue
        angles = tuple(rng.uniform(-60, 60, 3))
        left = moved(skeleton, {bone.name: angles}, bone.name, bone.tail + 0.1)
        right = moved(
            skeleton, {other_side(bone.name): angles}, other_side(bone.name), flip @ (bone.tail + 0.1)
        )
        assert right == pytest.approx(flip @ left)


@pytest.mark.parametrize(
    ("bone", "axis", "sign"),
    [("thigh.L", 2, 1), ("upper_arm.R", 2, 1), ("shin.L", 2, -1), ("forearm.L", 2, 1), ("head", 2, 1)],
)
def test_flexion_of_the_human_goes_the_anatomical_way(bone, axis, sign):
    skeleton = human_skeleton()
    tail = skeleton.bones[skeleton.index(bone)].tail
    step = moved(skeleton, {bone: (30, 0, 0)}, bone, tail) - tail
    assert sign * step[axis] > 0.02


def test_ball_swings_about_the_front_axis():
    skeleton = Skeleton((ball("leg", None, (0, 0, 0), (0, -1, 0), (-1, 0, 0)),))
    assert moved(skeleton, {"leg": (0, 0, 90)}, "leg", (0, -1, 0)) == pytest.approx((1, 0, 0))
    assert moved(skeleton, {"leg": (90, 0, 0)}, "leg", (0, -1, 0)) == pytest.approx((0, 0, 1))


def test_segment_distance_against_dense_sampling():
    rng = np.random.default_rng(0)
    points, start, end = rng.normal(size=(100, 3)), rng.normal(size=3), rng.normal(size=3)
    samples = start + np.linspace(0, 1, 2001)[:, None] * (end - start)
    slow = np.linalg.norm(points[:, None] - samples, axis=2).min(axis=1)
    assert segment_distance(points, start, end) == pytest.approx(slow, abs=1e-4)
