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


STRANGE = [0, -3, True, 5000, "ring", "ring:0", "dome:4", "ring:x", [], [[0, 0, 0]], [[1, 2]], {}]


@pytest.mark.parametrize("views", [*STRANGE, [[1, 2, np.nan]]])
def test_unknown_sets_are_refused(views):
    with pytest.raises(InputError, match="views"):
        viewpoints.directions(views)
