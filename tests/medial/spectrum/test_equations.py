"""Eqs. 11-13 against sums written out, and heat on a circle."""

from math import exp

import numpy as np
import pytest

from medial.spectrum.equations import diffused, diffusion_kernel, heat_rate

VALUES = np.array([0.0, 0.7, 2.5])
FUNCTIONS = np.array([[0.5, 1.1, -0.3], [0.5, -0.4, 0.8], [0.5, 0.2, -1.2], [0.5, -0.9, 0.6]])
F, AREAS = np.array([1.0, -2.0, 0.5, 3.0]), np.array([0.4, 1.3, 0.9, 0.7])


def test_heat_flows_against_the_laplacian():
    """Eq. 11 of the path of two edges: the middle gains what both ends lose."""
    laplacian = np.array([[1.0, -1, 0], [-1, 2, -1], [0, -1, 1]])
    assert heat_rate(laplacian, np.array([3.0, 0, 1])) == pytest.approx([-3, 4, -1])


def test_diffused_heat_is_a_sum_over_the_surface():
    """Eq. 12."""
    kernel = np.random.default_rng(0).uniform(size=(4, 4))
    written = [sum(kernel[i, j] * F[j] * AREAS[j] for j in range(4)) for i in range(4)]
    assert diffused(kernel, F, AREAS) == pytest.approx(written)


def test_kernel_is_a_sum_over_the_modes():
    """Eq. 13."""
    written = [
        [sum(exp(-VALUES[k] * 0.6) * FUNCTIONS[i, k] * FUNCTIONS[j, k] for k in range(3)) for j in range(4)]
        for i in range(4)
    ]
    assert diffusion_kernel(VALUES, FUNCTIONS, 0.6) == pytest.approx(np.array(written))


def test_a_cosine_on_a_circle_decays_with_its_eigenvalue():
    """cos(2 x) on the unit circle: exp(-4 t)."""
    x = np.arange(64) * 2 * np.pi / 64
    areas = np.full(64, 2 * np.pi / 64)
    modes = [np.full(64, (2 * np.pi) ** -0.5)]
    modes += [wave(k * x) / np.sqrt(np.pi) for k in (1, 2) for wave in (np.cos, np.sin)]
    kernel = diffusion_kernel(np.array([0.0, 1, 1, 4, 4]), np.column_stack(modes), 0.3)
    assert diffused(kernel, np.cos(2 * x), areas) == pytest.approx(exp(-4 * 0.3) * np.cos(2 * x))
