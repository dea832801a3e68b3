import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from evaluation.metrics.medial_errors import medial_distances, medial_paths
from medial import Diffusion

GAP, LENGTH, RADIUS = 0.3, 1.0, 0.06


def u_tube(n=3000, seed=0):
    """Samples of a tube around two parallel legs and the straight piece that joins them at the bottom."""
    rng = np.random.default_rng(seed)
    along = rng.uniform(0, 2 * LENGTH + GAP, n)
    first, last = along < LENGTH, along > LENGTH + GAP
    axis = np.zeros((n, 3))
    axis[:, 0] = np.clip(along - LENGTH, 0, GAP)
    axis[:, 1] = np.where(first, LENGTH - along, np.where(last, along - LENGTH - GAP, 0))
    turn = rng.uniform(0, 2 * np.pi, n)
    across = np.where((first | last)[:, None], [1.0, 0, 0], [0, 1.0, 0])
    normals = np.cos(turn)[:, None] * across + np.sin(turn)[:, None] * [0, 0, 1.0]
    return along, Diffusion(
        points=axis + RADIUS * normals,
        normals=normals,
        areas=np.ones(n),
        eigenvalues=np.array([0.0]),
        eigenfunctions=np.full((n, 1), n**-0.5),
        centers=axis,
        radii=np.full(n, RADIUS),
        operator="medial",
    )


ALONG, TUBE = u_tube()
PATHS = medial_paths(TUBE)


def test_the_way_between_two_legs_leads_through_the_body():
    tips = TUBE.points[[ALONG.argmin()]], TUBE.points[[ALONG.argmax()]]
    straight, along = medial_distances(TUBE, *tips, PATHS)
    assert straight[0] == pytest.approx(GAP, abs=0.01)
    assert along[0] == pytest.approx(2 * LENGTH + GAP, rel=0.05)


def test_around_a_limb_nothing_is_far():
    there = np.abs(ALONG - 0.5) < 0.01
    ring = TUBE.points[there]
    straight, along = medial_distances(TUBE, ring, ring[::-1], PATHS)
    assert (straight < 0.021).all()
    assert (along < 0.05).all()


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_distances_along_the_body_are_symmetric_and_between_the_straight_and_the_true_ones(seed):
    here, there = np.random.default_rng(seed).integers(len(TUBE), size=(2, 50))
    straight, along = medial_distances(TUBE, TUBE.points[here], TUBE.points[there], PATHS)
    back = medial_distances(TUBE, TUBE.points[there], TUBE.points[here], PATHS)[1]
    assert np.allclose(along, back)
    assert (along >= straight).all()
    true = np.abs(ALONG[here] - ALONG[there])
    assert (along <= 1.08 * true + RADIUS).all()  # nodes around a ring: a zigzag
    assert medial_distances(TUBE, TUBE.points[here], TUBE.points[here], PATHS)[1].max() == 0
