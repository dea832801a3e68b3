"""The same input gives the same map: to the bit on any number of threads, nearly so however it is presented.

docs/reproducibility.md says how near on scans, and what a change of processor or of libraries does.
"""

import os
import subprocess
import sys
from dataclasses import replace
from functools import cache
from pathlib import Path

import numba
import numpy as np
import pytest
from threadpoolctl import threadpool_limits

from medial import Diffusion, match
from tests.medial.clouds import body, rotation
from tests.medial.matching.registration.directions import BENT, SMALL
from tests.medial.posed import bent, bent_figure, figure

MODES = 60
QUICK = replace(SMALL, samples=80, restarts=2, nodes=24, fine_nodes=40, finalists=1, paths=False)


def on_threads(count, monkeypatch, function):
    """What a function gives where everything may use so many threads."""
    monkeypatch.setattr(numba.config, "NUMBA_NUM_THREADS", count)
    monkeypatch.setenv("OMP_NUM_THREADS", str(count))
    with threadpool_limits(count, user_api="blas"):
        return function()


def test_the_number_of_threads_changes_no_bit_of_an_operator(monkeypatch):
    """With so many points that eigenpairs are found by iteration, as on scans."""
    points, normals = body(1300)
    one, two = (
        on_threads(count, monkeypatch, lambda: Diffusion.from_points(points, normals, modes=MODES))
        for count in (1, 2)
    )
    for name in ("eigenvalues", "eigenfunctions", "areas", "centers", "radii"):
        assert np.array_equal(getattr(one, name), getattr(two, name)), name


def test_the_number_of_threads_changes_no_bit_of_a_map(monkeypatch):
    one, two = (
        on_threads(count, monkeypatch, lambda: match(figure(), bent_figure(*BENT), QUICK)) for count in (1, 2)
    )
    assert np.array_equal(one.source_to_target, two.source_to_target)
    assert np.array_equal(one.confidence, two.confidence)
    assert one.probability == two.probability


MAP = """
import hashlib
from medial import match
from tests.medial.test_same_numbers import BENT, QUICK, bent_figure, figure

found = match(figure(), bent_figure(*BENT), QUICK)
for array in (figure().areas, figure().radii, found.source_to_target, found.confidence):
    print(hashlib.sha1(array.tobytes()).hexdigest())
"""


@pytest.mark.slow
@pytest.mark.long
def test_a_processor_without_wide_vectors_changes_no_bit_of_a_map(tmp_path):
    """Nor does the order in which kernels are compiled: these are compiled anew, ours were loaded."""
    root = Path(__file__).parents[2]
    found = [
        subprocess.check_output([sys.executable, "-c", MAP], text=True, cwd=root, env={**os.environ, **more})
        for more in ({}, {"NUMBA_CPU_NAME": "generic", "NUMBA_CACHE_DIR": str(tmp_path)})
    ]
    assert found[0] == found[1]
    assert len(found[0].split()) == 4


def moved(points, normals, seed):
    """Turned, 100 body lengths away."""
    turn = rotation(seed)
    return points @ turn.T + 100 * np.ptp(points, axis=0).max() * turn[0], normals @ turn.T


def disturbed(points, normals, seed):
    return points + 1e-12 * np.random.default_rng(seed).standard_normal(points.shape), normals


CHANGES = {
    "turned and far away": moved,
    "other last digits": disturbed,
    "in another unit and order": lambda points, normals, seed: (1000 * points, normals),
}


@cache
def places_and_errors(change=None):
    """Where each point of the figure goes, and how far that is from where it belongs, in sqrt(area)."""
    clouds = (figure().points, figure().normals), bent(*body(800, seed=3), *BENT)
    diffusions, orders = [], []
    for seed, cloud in enumerate(clouds):
        points, normals = CHANGES[change](*cloud, seed) if change else cloud
        order = np.arange(len(points))
        if change == "in another unit and order":
            order = np.random.default_rng(seed).permutation(order)
        orders.append(order)
        diffusions.append(Diffusion.from_points(points[order], normals[order], modes=MODES))
    mapped = orders[1][match(*diffusions, QUICK).source_to_target][np.argsort(orders[0])]
    unit = np.sqrt(figure().areas.sum())
    places = clouds[1][0][mapped] / unit
    return places, np.linalg.norm(places - bent(*clouds[0], *BENT)[0] / unit, axis=1)


@pytest.mark.parametrize("change", CHANGES)
def test_maps_hardly_depend_on_how_clouds_are_presented(change):
    """Some points go to a neighbour of their match, and none farther; the mean error stays."""
    (places, errors), (others, after) = places_and_errors(), places_and_errors(change)
    assert abs(after.mean() - errors.mean()) < 0.002
    assert np.linalg.norm(places - others, axis=1).mean() < 0.01
