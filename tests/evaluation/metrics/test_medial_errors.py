from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial import cKDTree

from evaluation.metrics.medial_errors import BLOCK, MedialRuler
from medial import Diffusion
from medial.matching.landmarks.medial_paths import MedialPaths

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


@cache
def tube():
    """Where its samples lie along it, their diffusion and the ruler."""
    along, diffusion = u_tube()
    return along, diffusion, MedialRuler.of(diffusion)


def test_the_way_between_two_legs_leads_through_the_body():
    along_tube, diffusion, ruler = tube()
    tips = diffusion.points[[along_tube.argmin()]], diffusion.points[[along_tube.argmax()]]
    straight, along = ruler.distances(*tips)
    assert straight[0] == pytest.approx(GAP, abs=0.01)
    assert along[0] == pytest.approx(2 * LENGTH + GAP, rel=0.05)


def test_around_a_limb_nothing_is_far():
    along_tube, diffusion, ruler = tube()
    there = np.abs(along_tube - 0.5) < 0.01
    ring = diffusion.points[there]
    straight, along = ruler.distances(ring, ring[::-1])
    assert (straight < 0.021).all()
    assert (along < 0.05).all()


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 10**6))
def test_distances_along_the_body_are_symmetric_and_between_the_straight_and_the_true_ones(seed):
    along_tube, diffusion, ruler = tube()
    here, there = np.random.default_rng(seed).integers(len(diffusion), size=(2, 50))
    straight, along = ruler.distances(diffusion.points[here], diffusion.points[there])
    back = ruler.distances(diffusion.points[there], diffusion.points[here])[1]
    assert np.allclose(along, back)
    assert (along >= straight).all()
    true = np.abs(along_tube[here] - along_tube[there])
    assert (along <= 1.08 * true + RADIUS).all()  # nodes around a ring: a zigzag
    assert ruler.distances(diffusion.points[here], diffusion.points[here])[1].max() == 0


def small(n=9, seed=0):
    """A cloud with arbitrary centres, and arbitrary paths between five nodes."""
    random = np.random.default_rng(seed)
    diffusion = Diffusion(
        points=random.normal(size=(n, 3)),
        normals=np.tile([0, 0, 1.0], (n, 1)),
        areas=random.uniform(0.5, 1.5, n),
        eigenvalues=np.array([0.0]),
        eigenfunctions=np.full((n, 1), n**-0.5),
        centers=random.normal(size=(n, 3)),
        radii=np.full(n, 0.1),
        operator="medial",
    )
    lengths = random.uniform(0, 12, (5, 5))
    nearest = random.permutation(np.arange(n) % 5)
    return diffusion, MedialPaths(np.array([4, 0, 7, 2, 8]), lengths, np.full(5, 0.1), nearest)


def by_loops(diffusion, paths, p, q):
    """Straight and along the body between the samples nearest to two places."""
    k, m = (min(range(len(diffusion)), key=lambda i: sum((diffusion.points[i] - x) ** 2)) for x in (p, q))
    straight = np.sqrt(sum((diffusion.centers[k] - diffusion.centers[m]) ** 2))
    along = paths.lengths[paths.nearest[k], paths.nearest[m]]
    for sample in (k, m):
        node = diffusion.centers[paths.nodes[paths.nearest[sample]]]
        along -= np.sqrt(sum((diffusion.centers[sample] - node) ** 2))
    return straight, max(straight, along)


def test_both_distances_by_loops():
    diffusion, paths = small()
    right, found = np.random.default_rng(1).normal(size=(2, 30, 3))
    expected = [by_loops(diffusion, paths, p, q) for p, q in zip(right, found, strict=True)]
    straight, along = MedialRuler(diffusion, paths, cKDTree(diffusion.points)).distances(right, found)
    assert np.column_stack([straight, along]) == pytest.approx(np.array(expected))
    assert 5 < (along > straight).sum() < 25


def test_means_over_the_body_are_weighted_by_area():
    """More places than are held at once."""
    diffusion, paths = small()
    right = np.random.default_rng(2).normal(size=(BLOCK + 7, 3))
    expected = [
        sum(
            area * np.array(by_loops(diffusion, paths, p, q))
            for q, area in zip(diffusion.points, diffusion.areas, strict=True)
        )
        / sum(diffusion.areas)
        for p in right
    ]
    found = MedialRuler(diffusion, paths, cKDTree(diffusion.points)).mean_distances(right)
    assert np.column_stack(found) == pytest.approx(np.array(expected))


def test_one_tree_serves_all_distances(monkeypatch):
    """Queries of every score go to the tree that the ruler was made with."""
    _, diffusion = u_tube(30)
    ruler = MedialRuler.of(diffusion)
    monkeypatch.setattr("evaluation.metrics.medial_errors.cKDTree", None)
    places = diffusion.points[:5]
    assert ruler.distances(places, places)[0].max() == 0
    assert (ruler.mean_distances(places)[0] > 0).all()


def test_a_small_body_has_a_node_at_every_sample():
    _, diffusion = u_tube(30)
    assert sorted(MedialRuler.of(diffusion).paths.nodes.tolist()) == list(range(30))
