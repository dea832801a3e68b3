"""The operator keeps its meaning whatever the number of points and where they lie (`docs/operator.md`)."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from medial import Diffusion, density_weights, similarity, surface_areas
from tests.medial import clouds


def compare(coarse, fine, probes, modes=50):
    """Scale between the eigenvalues, their spread about it, and two relative differences of m_t by time.

    The first is that of all m_t(x, y) together, in the Frobenius norm; the second the median over the probes
    of that of m_t(x, x).
    """
    ratios = coarse.eigenvalues[1:modes] / fine.eigenvalues[1:modes]
    scale = np.exp(np.log(ratios).mean())
    times = np.geomspace(4 * np.log(10) / fine.eigenvalues[modes], 4 * np.log(10) / fine.eigenvalues[1], 8)
    rows = [cKDTree(each.points).query(probes)[1] for each in (coarse, fine)]
    errors, medians = [], []
    for t in times:
        one, other = coarse.kernel(t / scale, rows[0], rows[0]), fine.kernel(t, rows[1], rows[1])
        errors.append(np.linalg.norm(one - other) / np.linalg.norm(other))
        medians.append(np.median(np.abs(np.diagonal(one) / np.diagonal(other) - 1)))
    return scale, np.std(np.log(ratios / scale)), np.array(errors), np.array(medians)


def test_gamma_and_phi_keep_their_meaning():
    """Similarity per point of the medial axis: the sum of phi a over a row is an integral.

    Eq. 5 as written counts points: it has the integral of its own number of points, for which all weigh 1.
    """
    sums = []
    for n in (1500, 4500):
        points, normals = clouds.body(n)
        areas = surface_areas(points, normals)
        ours, of_its_size, written = (
            np.median(similarity(points, normals, weights=weights) @ areas)
            for weights in (density_weights(areas), density_weights(areas, n), None)
        )
        sums.append(ours)
        assert written == pytest.approx(of_its_size, rel=0.05)
    assert sums[0] == pytest.approx(sums[1], rel=0.08)


def test_spectrum_of_a_sparser_cloud():
    fine = Diffusion.from_points(*clouds.body(5000), modes=51)
    coarse = Diffusion.from_points(*clouds.body(2500), modes=51)
    scale, spread, errors, medians = compare(coarse, fine, clouds.body(150)[0])
    assert scale == pytest.approx(1, abs=0.06)
    assert spread < 0.06
    assert errors.max() < 0.15
    assert medians.max() < 0.08


@pytest.mark.slow
@pytest.mark.long
def test_spectrum_from_5000_to_40000_points():
    clouds_by_size = {n: clouds.body(n) for n in (5000, 10_000, 20_000, 40_000)}
    made = {n: Diffusion.from_points(*cloud, modes=51) for n, cloud in clouds_by_size.items()}
    for n in (5000, 10_000, 20_000):
        scale, spread, errors, medians = compare(made[n], made[40_000], clouds.body(200)[0])
        assert scale == pytest.approx(1, abs=0.06), n
        assert spread < 0.05, n
        assert errors.max() < 0.12, n
        assert medians.max() < 0.06, n
        assert made[n].areas.sum() == pytest.approx(made[40_000].areas.sum(), rel=0.06), n


@pytest.mark.slow
def test_spectrum_of_an_unevenly_sampled_cloud():
    """The upper half three times as dense as the lower one."""
    points, normals = clouds.body(16_000)
    upper = np.flatnonzero(points[:, 2] > 0)
    lower = np.flatnonzero(points[:, 2] <= 0)
    lower = lower[: len(lower) // 3]  # farthest-point order: any beginning is uniform
    chosen = np.concatenate([upper, lower])
    uneven = Diffusion.from_points(points[chosen], normals[chosen], modes=51)
    even = Diffusion.from_points(points, normals, modes=51)
    scale, spread, errors, _ = compare(uneven, even, clouds.body(200)[0])
    assert scale == pytest.approx(1, abs=0.08)
    assert spread < 0.08
    assert errors.max() < 0.2
