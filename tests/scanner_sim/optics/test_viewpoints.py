import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from datasets_gen import InputError
from scanner_sim.optics import viewpoints


@given(st.integers(1, 64))
@settings(max_examples=20, deadline=None)
def test_sphere_sets_are_unit_and_start_at_the_front(count):
    directions = viewpoints.directions(count)
    assert directions.shape == (count, 3)
    assert np.allclose(np.linalg.norm(directions, axis=1), 1)
    assert np.allclose(directions[0], [0, 0, 1])


@pytest.mark.parametrize(("count", "degrees"), [(4, 109.47), (6, 90.0), (12, 63.43)])
def test_small_sets_are_the_regular_solids(count, degrees):
    directions = viewpoints.directions(count)
    cosine = directions @ directions.T - 2 * np.eye(count)
    assert np.degrees(np.arccos(cosine.max())) == pytest.approx(degrees, abs=0.2)


@pytest.mark.parametrize("count", range(4, 41))
def test_sphere_sets_are_near_uniform(count):
    """The closest pair keeps most of the spacing of a hexagonal packing, and the mean direction vanishes."""
    directions = viewpoints.directions(count)
    cosine = directions @ directions.T - 2 * np.eye(count)
    packed = np.sqrt(8 * np.pi / (np.sqrt(3) * count))
    assert np.arccos(cosine.max()) > 0.8 * packed
    assert np.linalg.norm(directions.mean(axis=0)) < 0.06


@pytest.mark.parametrize(("up", "axis", "front"), [("x", 0, 1), ("y", 1, 2), ("z", 2, 0)])
@pytest.mark.parametrize("views", ["ring:6", "opposed"])
def test_rings_lie_across_the_up_axis_and_start_at_the_front(views, up, axis, front):
    directions = viewpoints.directions(views, up)
    assert np.allclose(directions[:, axis], 0)
    assert np.allclose(directions[0], np.eye(3)[front])
    assert np.allclose(directions.sum(axis=0), 0)
    assert len(directions) == (2 if views == "opposed" else 6)


@pytest.mark.parametrize(("up", "front", "left"), [("x", 1, 2), ("y", 2, 0), ("z", 0, 1)])
@pytest.mark.parametrize("count", [1, 2, 3])
def test_rigs_on_one_side_look_at_that_side(up, front, left, count):
    sides = {"front": np.eye(3)[front], "back": -np.eye(3)[front]}
    sides |= {"left": np.eye(3)[left], "right": -np.eye(3)[left]}
    for name, side in sides.items():
        directions = viewpoints.directions(f"{name}:{count}", up)
        assert directions.shape == (count, 3)
        assert np.allclose(directions[:, "xyz".index(up)], 0)
        middle = directions.mean(axis=0)
        assert np.allclose(middle / np.linalg.norm(middle), side)
        between = np.degrees(np.arccos(np.einsum("vd,vd->v", directions[1:], directions[:-1])))
        assert np.allclose(between, 60)


def test_the_left_of_a_body_that_faces_the_front_is_seen_on_the_right_of_the_image():
    pose = viewpoints.poses(viewpoints.directions("front:1"), 100.0)[0]
    left = viewpoints.directions("left:1")[0]
    assert np.allclose(pose[:3, :3].T @ left, [1, 0, 0])


def test_explicit_directions_are_normalised_in_order():
    assert np.allclose(viewpoints.directions([[2, 0, 0], [0, 3, 4]]), [[1, 0, 0], [0, 0.6, 0.8]])


@given(st.integers(1, 20), st.sampled_from("xyz"), st.floats(1, 1e3))
@settings(max_examples=25, deadline=None)
def test_cameras_look_at_the_origin_with_proper_rotations(count, up, distance):
    toward = viewpoints.directions(count, up)
    poses = viewpoints.poses(toward, distance, up)
    turns = poses[:, :3, :3]
    assert np.allclose(np.einsum("vij,vik->vjk", turns, turns), np.eye(3), atol=1e-12)
    assert np.allclose(np.linalg.det(turns), 1)
    assert np.allclose(poses[:, :3, 3] + distance * poses[:, :3, 2], 0, atol=1e-9 * distance)
    assert (poses[:, "xyz".index(up), 1] <= 1e-9).all()  # image down is never up


@pytest.mark.parametrize(("up", "axis", "front"), [("x", 0, 1), ("y", 1, 2), ("z", 2, 0)])
def test_a_turntable_turns_the_part_counter_clockwise_under_a_raised_camera(up, axis, front):
    """A point of the part that the first view sees in front is seen on the right after a quarter turn."""
    directions = viewpoints.directions("turntable:4@30", up)
    poses = viewpoints.poses(directions, 100.0, up)
    assert np.allclose(directions[:, axis], 0.5)
    assert np.allclose(np.delete(directions[0], [axis, front]), 0)
    assert directions[0, front] == pytest.approx(np.sqrt(0.75))
    seen = np.einsum("vji,vj->vi", poses[:, :3, :3], np.eye(3)[front] - poses[:, :3, 3])
    across = [0, 1, 0, -1]
    assert np.allclose(seen[:, 0], across, atol=1e-12)
    assert np.argmin(seen[:, 2]) == 0


def test_a_turntable_without_elevation_is_a_ring_the_other_way_round():
    ring, table = viewpoints.directions("ring:7"), viewpoints.directions("turntable:7")
    assert np.allclose(table, ring[[0, 6, 5, 4, 3, 2, 1]])


def test_matrices_come_back_as_tuples_and_as_orthonormal_poses():
    poses = viewpoints.poses(viewpoints.directions(5), 100.0)
    typed = np.round(poses, 6)  # as from a text file
    views = viewpoints.as_tuples(typed.tolist())
    assert isinstance(views[0][0], tuple)
    found = viewpoints.matrices(views)
    assert np.abs(found - poses).max() < 1e-5
    turns = found[:, :3, :3]
    assert np.allclose(np.einsum("vij,vik->vjk", turns, turns), np.eye(3), atol=1e-14)
    assert viewpoints.matrices("ring:3") is None
    assert viewpoints.matrices(((1, 0, 0),)) is None


def changed(row, column, value):
    pose = np.eye(4)
    pose[row, column] = value
    return [pose.tolist()]


@pytest.mark.parametrize(
    ("views", "match"),
    [
        (changed(0, 0, -1), "matrix 0 is no rotation"),
        (changed(1, 1, 1.1), "matrix 0 is no rotation"),
        (changed(3, 0, 1), "last row"),
        (changed(0, 3, np.nan), "finite"),
        ([np.eye(3).tolist()], "4 x 4"),
        (np.eye(4).tolist(), "list of"),
    ],
)
def test_matrices_that_are_no_poses_are_refused(views, match):
    with pytest.raises(InputError, match=match):
        viewpoints.as_tuples(views)


@given(st.integers(1, 9), st.floats(60, 300), st.floats(-80, 80).filter(lambda b: abs(b) > 1))
@settings(max_examples=25, deadline=None)
def test_both_cameras_look_at_one_point_from_both_sides_of_the_laser(count, depth, baseline):
    first = viewpoints.poses(viewpoints.directions(count), depth)
    second = viewpoints.second_camera(first, baseline, depth)
    laser = first[:, :3, 3] + baseline * first[:, :3, 0]
    assert np.allclose(laser, second[:, :3, 3] - baseline * second[:, :3, 0])
    assert np.allclose(second[:, :3, 3] + depth * second[:, :3, 2], 0, atol=1e-9)
    assert np.allclose(np.linalg.det(second[:, :3, :3]), 1)
    sheet = -laser / np.linalg.norm(laser, axis=1, keepdims=True)  # towards that point
    across = np.cross(sheet, first[:, :3, 1])
    offsets = [np.einsum("vd,vd->v", each[:, :3, 3] - laser, across) for each in (first, second)]
    assert np.allclose(offsets[0], -offsets[1])


STRANGE = [0, -3, True, 5000, "ring", "ring:0", "dome:4", "ring:x", [], [[0, 0, 0]], [[1, 2]], {}]
STRANGE += ["front", "front:0", "left:4", "back:2@10", "side:2", "opposed:2"]
STRANGE += ["turntable", "turntable:0", "turntable:4@", "turntable:4@90", "ring:4@10", "ring:\u0664"]


@pytest.mark.parametrize("views", [*STRANGE, [[1, 2, np.nan]]])
def test_unknown_sets_are_refused(views):
    with pytest.raises(InputError, match="views"):
        viewpoints.directions(views)
