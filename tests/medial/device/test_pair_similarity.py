"""Similarities of a device equal those of the processor, but for what single precision changes."""

from importlib import import_module

import numpy as np
import pytest

from datasets_gen.records import InputError
from medial import similarity
from medial.similarity.critical_radius import critical_grid
from medial.similarity.leaves import LEAF, kd_cloud
from tests.medial import clouds
from tests.medial.devices import on_each, require

SINGLE = 1e-5  # what single precision may change in phi
CUTOFF = 1e-6

pytestmark = on_each


WEIGHTS = np.random.default_rng(0).uniform(0.2, 3, 501)
CASES = {
    "body": (clouds.body(2000), {}),
    "body with holes": (clouds.body(2000, holes=8), {}),
    "odd number of points": (clouds.body(701), {}),
    "planes": (clouds.planes(500), {}),
    "sphere": (clouds.sphere(500), {}),
    "weights": (clouds.torus(501), {"weights": WEIGHTS}),
    "settings": (clouds.body(700), {"sigma_e": 9.0, "sigma_t": 1.2, "r_cap": 0.1}),
    "no structure": (clouds.random_cloud(300), {"sigma_e": 20.0}),
    "far from the origin": ((clouds.body(700)[0] + 300, clouds.body(700)[1]), {}),
}


@pytest.mark.parametrize("name", CASES)
def test_equals_the_processor(device, name):
    require(device)
    cloud, settings = CASES[name]
    there = similarity(*cloud, **settings, cutoff=CUTOFF, device=device)
    here = similarity(*cloud, **settings, cutoff=CUTOFF)
    assert here.nnz > 1000
    assert abs(there - here).max() < SINGLE
    only = (there > 0) != (here > 0)
    assert only.nnz <= here.nnz / 1000
    assert there.maximum(here).multiply(only).max() < CUTOFF * (1 + 1e-3)
    assert (there != there.T).nnz == 0
    assert not there.diagonal().any()
    assert there.has_canonical_format


def test_order_of_points_does_not_matter(device):
    require(device)
    points, normals = clouds.body(700)
    order = np.random.default_rng(1).permutation(700)
    phi = similarity(points, normals, device=device)
    again = similarity(points[order], normals[order], device=device)
    assert (again != phi[order][:, order]).nnz == 0


def test_size_of_batches_does_not_matter(device, monkeypatch):
    require(device)
    cloud = clouds.body(701, holes=4)
    phi = similarity(*cloud, device=device)
    monkeypatch.setattr(import_module("medial.device.pair_similarity"), "PAIRS_AT_ONCE", 30_000)
    monkeypatch.setattr(import_module("medial.device.leaf_lists"), "TESTS_AT_ONCE", 30_000)
    assert (similarity(*cloud, device=device) != phi).nnz == 0


def test_lists_hold_every_leaf_in_reach_nearest_first(device):
    jit = require(device)
    from medial.device.leaf_lists import leaf_lists

    points, normals = clouds.body(700)
    cloud, order = kd_cloud(points, normals, np.ones(700))
    grid = critical_grid(cloud, 20.0, 0.3, 0.2)
    lists = leaf_lists(jit, points[order], cloud.mass, grid, np.zeros(3))
    starts, leaves, near = lists.starts.numpy(), lists.leaves.numpy(), lists.near.numpy()
    assert len(starts) == len(grid.cells) + 1
    assert starts[1] == 0
    assert starts[-1] == len(leaves)
    for cell in range(1, len(grid.cells)):
        radius, center = grid.cells[cell, 0], grid.cells[cell, 1:]
        own = slice(starts[cell], starts[cell + 1])
        gap = np.linalg.norm(cloud.spheres[:, :3] - center, axis=1) - cloud.spheres[:, 3]
        assert set(np.flatnonzero(gap < radius)) <= set(leaves[own])
        assert (np.diff(near[own]) >= 0).all()
        assert near[own] == pytest.approx(np.maximum(gap[leaves[own]], 0), abs=1e-5)


def test_points_of_leaves_are_relative_to_their_centres(device):
    require(device)
    from medial.device.leaf_lists import leaf_blocks

    places = np.random.default_rng(0).normal(size=(61, 3))
    spheres, points = leaf_blocks(places, np.arange(1.0, 62.0))
    back = np.repeat(spheres[:, :3], LEAF, axis=0).astype(float) + points[:, :3]
    assert back[:61] == pytest.approx(places, abs=1e-6)
    assert points[:, 3].tolist() == [*range(1, 62), 0, 0, 0]
    assert (np.linalg.norm(points[:, :3], axis=1) <= np.repeat(spheres[:, 3], LEAF)).all()


def test_flat_clouds_have_no_medial_balls(device):
    require(device)
    points = np.zeros((100, 3))
    points[:, :2] = np.random.default_rng(0).uniform(size=(100, 2))
    assert similarity(points, np.tile([0.0, 0, 1], (100, 1)), device=device).nnz == 0


@pytest.mark.parametrize("r_cap", [1e-3, 0.05, 0.07, 0.08])
def test_few_or_no_similar_pairs(device, r_cap, monkeypatch):
    require(device)
    monkeypatch.setattr(
        import_module("medial.device.pair_similarity"), "PAIRS_AT_ONCE", 1
    )  # most without any
    cloud = clouds.body(300)
    there, here = similarity(*cloud, r_cap=r_cap, device=device), similarity(*cloud, r_cap=r_cap)
    assert there.nnz == here.nnz < 300
    assert abs(there - here).max() < SINGLE


def test_too_round_for_memory_is_an_input_error(device, monkeypatch):
    require(device)
    monkeypatch.setattr(import_module("medial.similarity.similarity"), "MOST_PAIRS", 1000)
    with pytest.raises(InputError, match="close to a ball"):
        similarity(*clouds.sphere(100), device=device)
