"""Modes found with the matrix on a device equal those of the processor."""

import numpy as np
import pytest
from scipy.sparse import csr_array, random_array

from medial import Diffusion, similarity, surface_areas
from medial.laplacian.weights import combine, gaussian_weights, laplacian
from medial.spectrum.filtered_lanczos import chebyshev
from medial.spectrum.modes import smallest_modes
from tests.medial import clouds
from tests.medial.devices import on_each, require

pytestmark = on_each


@pytest.fixture(scope="module")
def problem():
    points, normals = clouds.body(1500)
    areas = surface_areas(points, normals)
    phi, alpha = similarity(points, normals), gaussian_weights(points, areas).weights
    return laplacian(combine(phi, alpha, areas), areas), areas


@pytest.mark.parametrize("degree", [1, 4, 9])
def test_polynomial_equals_the_processors(device, degree):
    jit = require(device)
    from medial.device.chebyshev import chebyshev_on

    rng = np.random.default_rng(0)
    half = random_array((300, 300), density=0.003, rng=rng)
    matrix = csr_array(half + half.T)
    assert np.diff(matrix.indptr).min() == 0  # rows without entries
    block = rng.standard_normal((300, 16))
    there = chebyshev_on(jit, matrix)(block, degree, 0.5, 2.0)
    here = chebyshev(matrix, block, degree, 0.5, 2.0)
    assert there == pytest.approx(here, rel=1e-12, abs=1e-12 * np.abs(here).max())


def test_modes_equal_the_processors(device, problem):
    require(device)
    values, there, residual = smallest_modes(*problem, 60, device=device)
    expected, here, _ = smallest_modes(*problem, 60)
    assert residual < 1e-6
    assert values == pytest.approx(expected, abs=1e-9)
    overlap = there.T @ (problem[1][:, None] * here)
    assert np.abs(np.diag(overlap)) == pytest.approx(1, abs=1e-5)


def test_whole_operator(device):
    require(device)
    cloud = clouds.body(1500, holes=4)
    there = Diffusion.from_points(*cloud, modes=40, device=device)
    here = Diffusion.from_points(*cloud, modes=40)
    assert there.parameters["device"] == device
    assert there.eigenvalues == pytest.approx(here.eigenvalues, rel=1e-4, abs=1e-9)
    assert there.areas == pytest.approx(here.areas, rel=1e-3)
    times = 1 / here.eigenvalues[[5, 20]]
    assert there.signature(times) == pytest.approx(here.signature(times), rel=1e-3)
