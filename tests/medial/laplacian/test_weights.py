import numpy as np
import pytest
from scipy.sparse import csr_array

from medial import Departures, similarity, surface_areas
from medial.laplacian.equations import combined_weights, gaussian, point_cloud_laplacian, weighted_degrees
from medial.laplacian.weights import NEAREST, combine, degrees, diffusion_rates, gaussian_weights, laplacian
from medial.sparse import symmetric
from tests.medial import clouds


@pytest.fixture(scope="module")
def weights():
    points, normals = clouds.body(400)
    areas = surface_areas(points, normals)
    return similarity(points, normals), gaussian_weights(points, areas), areas


def test_gaussian_weights_follow_their_formula():
    points, normals = clouds.sphere(500)
    areas = surface_areas(points, normals)
    alpha, bandwidths = gaussian_weights(points, areas)
    rows, cols = alpha.nonzero()
    square = ((points[rows] - points[cols]) ** 2).sum(axis=1)
    assert alpha.data == pytest.approx(np.exp(-square / bandwidths))
    assert np.median(bandwidths) == pytest.approx(3 * areas.mean(), rel=0.03)
    assert bandwidths == pytest.approx(np.full(len(square), 3 * areas.mean()), rel=0.3)
    assert (alpha != alpha.T).nnz == 0


def test_one_bandwidth_without_truncation_is_the_gaussian(weights):
    """Without the departures, alpha is Eq. 2's; with truncation, its entries above the least weight."""
    points, areas = clouds.body(400)[0], weights[2]
    written = gaussian(points, 3 * areas.mean()) - np.eye(400)
    alpha, bandwidths = gaussian_weights(points, areas, departures=Departures.none())
    assert alpha.toarray() == pytest.approx(written, rel=1e-12, abs=1e-300)
    assert bandwidths == pytest.approx(np.full(alpha.nnz, 3 * areas.mean()))
    only_bandwidth = Departures(adaptive_bandwidth=False)
    cut = gaussian_weights(points, areas, departures=only_bandwidth).weights.toarray()
    assert cut == pytest.approx(np.where(written >= 1e-3, written, 0), rel=1e-12)


def test_truncation_only_drops_small_weights(weights):
    """With the adaptive bandwidth, what is kept by default is part of all weights."""
    points, areas = clouds.body(400)[0], weights[2]
    every = gaussian_weights(points, areas, departures=Departures(truncation=False)).weights.toarray()
    kept = weights[1].weights.toarray()
    assert kept[kept > 0] == pytest.approx(every[kept > 0], rel=1e-12)
    assert every[kept == 0].max() < 1e-2  # a few of more than 1e-3 lie beyond the 64 nearest points
    assert (every > 0).sum() > 2 * (kept > 0).sum()


def test_no_point_is_isolated():
    points, normals = clouds.sphere(300)
    points[0] *= 5
    points[1] *= 40
    alpha = gaussian_weights(points, surface_areas(points, normals)).weights
    assert np.diff(alpha.indptr).min() >= NEAREST
    assert alpha.max(axis=1).toarray().min() > 0.1


@pytest.mark.parametrize("n", [8, 9, 20])
def test_gaussian_weights_of_few_points(n):
    alpha = gaussian_weights(clouds.sphere(n)[0], np.full(n, 4 * np.pi / n)).weights
    assert np.diff(alpha.indptr).min() >= min(NEAREST, n - 1)


@pytest.mark.parametrize("eta", [0.0, 0.3, 1.0])
def test_combination_equals_equation_15(weights, eta):
    phi, alpha, areas = weights
    rates = diffusion_rates(alpha.bandwidths, areas.sum(), 5000)
    entries = csr_array((rates, alpha.weights.indices, alpha.weights.indptr), shape=alpha.weights.shape)
    for own, factors in ((1.0, 1.0), (rates, entries.toarray())):
        written = combined_weights(phi.toarray(), alpha.weights.toarray(), areas, eta, factors)
        assert combine(phi, alpha.weights, areas, eta, own).toarray() == pytest.approx(written, abs=1e-12)


def test_degrees_leave_the_point_itself_out():
    phi, areas = csr_array(np.array([[5.0, 1, 2], [1, 0, 0], [2, 0, 0]])), np.array([1.0, 2, 3])
    assert degrees(phi, areas) == pytest.approx([8, 1, 2])
    assert weighted_degrees(phi.toarray(), areas) == pytest.approx([8, 1, 2])


def test_zero_medial_degree_leaves_the_gaussian_part(weights):
    phi, alpha, areas = weights
    dense = phi.toarray()
    dense[5], dense[:, 5] = 0, 0
    sigma = combine(csr_array(dense), alpha.weights, areas).toarray()
    assert np.isfinite(sigma).all()
    assert sigma[5] == pytest.approx(combined_weights(0 * dense, alpha.weights.toarray(), areas)[5])


def test_rates_do_not_change_the_reference():
    assert diffusion_rates(np.array([3 * 2.0 / 1000]), 2.0, 1000) == pytest.approx([1])
    assert diffusion_rates(np.array([3 * 2.0 / 4000]), 2.0, 1000) == pytest.approx([4])


def test_laplacian_applies_equation_8(weights):
    phi, _, areas = weights
    f = np.random.default_rng(0).standard_normal(len(areas))
    expected = point_cloud_laplacian(f, phi.toarray(), areas)
    assert laplacian(phi, areas) @ f / areas == pytest.approx(expected, abs=1e-12)


def test_laplacian_is_symmetric_semidefinite_and_kills_constants(weights):
    phi, alpha, areas = weights
    matrix = laplacian(combine(phi, alpha.weights, areas), areas).toarray()
    assert matrix == pytest.approx(matrix.T, abs=1e-15)
    assert matrix.sum(axis=1) == pytest.approx(np.zeros(len(areas)), abs=1e-12)
    assert np.linalg.eigvalsh(matrix).min() > -1e-12


@pytest.mark.uncompiled
def test_symmetric_from_pairs():
    random = np.random.default_rng(0)
    i, j = np.triu_indices(30, 1)
    kept = random.uniform(size=len(i)) < 0.3
    i, j = i[kept], j[kept]
    swap = random.uniform(size=len(i)) < 0.5
    i, j = np.where(swap, j, i), np.where(swap, i, j)
    values = random.uniform(1, 2, len(i))
    dense = np.zeros((30, 30))
    dense[i, j], dense[j, i] = values, values
    matrix = symmetric(i, j, values, 30)
    assert (matrix.toarray() == dense).all()
    rows = np.repeat(np.arange(30), np.diff(matrix.indptr))
    assert (np.diff(rows * 30 + matrix.indices) > 0).all()
