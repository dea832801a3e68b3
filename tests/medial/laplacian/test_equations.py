"""Eqs. 2, 3, 8, 14 and 15 against their sums, written out one term after the other."""

from math import exp, sqrt

import numpy as np
import pytest

from medial.laplacian.equations import (
    combined_weights,
    gaussian,
    laplacian_over_medial_axis,
    laplacian_over_surface,
    point_cloud_laplacian,
    weighted_degrees,
)

N, H = 5, 0.6
RANDOM = np.random.default_rng(0)
POINTS = RANDOM.uniform(size=(N, 3))
F, AREAS, DENSITY = RANDOM.uniform(0.5, 1.5, (3, N))
PHI, ALPHA, RATES = RANDOM.uniform(0.1, 0.9, (3, N, N))


def alpha(p, q):
    return exp(-sum((a - b) ** 2 for a, b in zip(p, q, strict=True)) / H)


def test_gaussian_of_squared_distances():
    assert gaussian(POINTS, H) == pytest.approx(np.array([[alpha(p, q) for q in POINTS] for p in POINTS]))
    assert gaussian(np.array([[0.0, 0, 0], [1, 2, 2]]), 9.0)[0] == pytest.approx([1, exp(-1)])


def test_laplacian_over_the_medial_axis():
    """Eq. 2: f(x) int alpha rho - int f alpha rho over the medial axis."""
    written = [
        F[x] * sum(alpha(POINTS[x], POINTS[y]) * DENSITY[y] * AREAS[y] for y in range(N))
        - sum(F[y] * alpha(POINTS[x], POINTS[y]) * DENSITY[y] * AREAS[y] for y in range(N))
        for x in range(N)
    ]
    assert laplacian_over_medial_axis(F, POINTS, AREAS, DENSITY, H) == pytest.approx(written)


def test_laplacian_over_the_surface():
    """Eq. 3: the same over the surface, whose density is implicit."""
    written = [
        sum((F[p] - F[q]) * alpha(POINTS[p], POINTS[q]) * AREAS[q] for q in range(N)) for p in range(N)
    ]
    assert laplacian_over_surface(F, POINTS, AREAS, H) == pytest.approx(written)


def test_point_cloud_laplacian():
    """Eq. 8."""
    written = [
        F[i] * sum(PHI[i, j] * AREAS[j] for j in range(N))
        - sum(F[j] * PHI[i, j] * AREAS[j] for j in range(N))
        for i in range(N)
    ]
    assert point_cloud_laplacian(F, PHI, AREAS) == pytest.approx(written)
    assert point_cloud_laplacian(np.full(N, 3.0), PHI, AREAS) == pytest.approx(np.zeros(N), abs=1e-14)


def degree(weights, i):
    return sum(weights[i, j] * AREAS[j] for j in range(N) if j != i)


def test_degrees_leave_the_point_itself_out():
    """Eq. 14."""
    assert weighted_degrees(PHI, AREAS) == pytest.approx([degree(PHI, i) for i in range(N)])


def combined(i, j, eta, rate):
    medial = PHI[i, j] / sqrt(degree(PHI, i) * degree(PHI, j))
    return (1 - eta) * medial + eta * rate * ALPHA[i, j] / sqrt(degree(ALPHA, i) * degree(ALPHA, j))


@pytest.mark.parametrize("eta", [0.0, 0.3, 1.0])
def test_combination_of_both_weights(eta):
    """Eq. 15."""
    written = [[combined(i, j, eta, RATES[i, j]) for j in range(N)] for i in range(N)]
    assert combined_weights(PHI, ALPHA, AREAS, eta, RATES) == pytest.approx(np.array(written))


def test_both_weights_count_the_same_unless_said_otherwise():
    """The paper's eta is 0.5, and it knows no rates."""
    written = [[combined(i, j, 0.5, 1) for j in range(N)] for i in range(N)]
    assert combined_weights(PHI, ALPHA, AREAS) == pytest.approx(np.array(written))


def test_combination_is_in_one_over_area():
    """In units of length ten times as large areas are a hundredth."""
    found = combined_weights(PHI, ALPHA, AREAS / 100, 0.3)
    assert found == pytest.approx(100 * combined_weights(PHI, ALPHA, AREAS, 0.3))


def test_a_point_without_weights_keeps_the_other_part():
    """All of its weights are 0, whatever they are divided by; those of the others stay as they are."""
    phi = PHI.copy()
    phi[2], phi[:, 2] = 0, 0
    with np.errstate(all="raise"):
        found = combined_weights(phi, ALPHA, AREAS, 0.4)
    alone = combined_weights(0 * PHI, ALPHA, AREAS, 0.4)
    assert found[2] == pytest.approx(alone[2])
    assert alone[2, 3] == pytest.approx(0.4 * ALPHA[2, 3] / sqrt(degree(ALPHA, 2) * degree(ALPHA, 3)))
    medial = 0.6 * phi[0, 1] / sqrt(degree(phi, 0) * degree(phi, 1))
    assert found[0, 1] == pytest.approx(medial + alone[0, 1])
