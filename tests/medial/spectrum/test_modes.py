import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse import block_diag, csr_array, diags_array

from datasets_gen.records import InputError
from medial import similarity, surface_areas
from medial.laplacian.weights import combine, gaussian_weights, laplacian
from medial.spectrum.filtered_lanczos import chebyshev, filtered_lanczos
from medial.spectrum.krylov import multiply
from medial.spectrum.modes import smallest_modes
from tests.medial import clouds


@pytest.fixture(scope="module")
def problem():
    points, normals = clouds.body(1500)
    areas = surface_areas(points, normals)
    phi, alpha = similarity(points, normals), gaussian_weights(points, areas).weights
    stiffness = laplacian(combine(phi, alpha, areas), areas)
    return stiffness, areas, eigh(stiffness.toarray(), np.diag(areas), eigvals_only=True)


def ring(n):
    """Graph Laplacian of a cycle, eigenvalues 2 - 2 cos(2 pi k / n)."""
    once = np.ones(n)
    matrix = diags_array([2 * once, -once[1:], -once[1:]], offsets=[0, 1, -1]).tolil()
    matrix[0, n - 1] = matrix[n - 1, 0] = -1
    return csr_array(matrix.tocsr())


def check(modes, stiffness, areas, tolerance=1e-6):
    values, psi, _ = modes
    assert psi.T @ (areas[:, None] * psi) == pytest.approx(np.eye(len(values)), abs=1e-9)
    residual = (stiffness @ psi) / areas[:, None] ** 0.5 - areas[:, None] ** 0.5 * psi * values
    assert np.linalg.norm(residual, axis=0).max() < tolerance * 3
    assert (np.diff(values) >= -1e-12).all()


@pytest.mark.parametrize("modes", [5, 60, 200])
def test_equals_dense_solver(problem, modes):
    stiffness, areas, values = problem
    found = smallest_modes(stiffness, areas, modes)
    assert found[2] < 1e-6
    assert found[0] == pytest.approx(values[:modes], abs=1e-9)
    check(found, stiffness, areas)


@pytest.mark.parametrize("modes", [1, 40, 200])
def test_factorising_solver_equals_dense(problem, modes):
    stiffness, areas, values = problem
    found = smallest_modes(stiffness, areas, modes, factorise=True)
    assert found[0] == pytest.approx(values[:modes], abs=1e-9)
    check(found, stiffness, areas)


@pytest.mark.parametrize("factorise", [False, True])
def test_wide_spectrum(factorise):
    """A long cycle: the wanted eigenvalues are a ten-thousandth of the largest, in pairs."""
    stiffness, areas = ring(3000), np.ones(3000)
    exact = np.sort(2 - 2 * np.cos(2 * np.pi * np.arange(3000) / 3000))[:20]
    found = smallest_modes(stiffness, areas, 20, tolerance=1e-8, factorise=factorise)
    assert found[0] == pytest.approx(exact, abs=1e-8)
    check(found, stiffness, areas)


@pytest.mark.parametrize("factorise", [False, True])
@pytest.mark.parametrize("pieces", [2, 40])
def test_disconnected(pieces, factorise):
    """Zero is found once for every component, also when there are more than vectors in a block."""
    size = 4000 // pieces
    stiffness, areas = csr_array(block_diag([ring(size)] * pieces).tocsr()), np.ones(size * pieces)
    exact = np.sort(np.tile(2 - 2 * np.cos(2 * np.pi * np.arange(size) / size), pieces))
    found = smallest_modes(stiffness, areas, pieces + 3, factorise=factorise)
    assert (found[0][:pieces] == 0).all()
    assert found[0][pieces:] == pytest.approx(exact[pieces : pieces + 3], abs=1e-6)
    constant = found[1][:, :pieces].reshape(pieces, size, pieces)
    assert np.ptp(constant, axis=1).max() < 1e-12


def test_more_components_than_modes():
    stiffness, areas = csr_array((1500, 1500)), np.linspace(1, 2, 1500)
    found = smallest_modes(stiffness, areas, 10)
    assert not found[0].any()
    check(found, stiffness, areas)
    assert found[1][-10:].any(axis=1).all()  # the largest components


def test_threads_do_not_matter(problem, monkeypatch):
    stiffness, areas, _ = problem
    results = []
    for threads in (1, 3):
        monkeypatch.setattr("datasets_gen.compiled.thread_count", lambda threads=threads: threads)
        results.append(smallest_modes(stiffness, areas, 30)[1])
    assert (results[0] == results[1]).all()


def test_unreached_residual_is_reported(problem, caplog):
    stiffness, areas, _ = problem
    found = smallest_modes(stiffness, areas, 30, tolerance=1e-17)
    assert "residual" in caplog.text
    assert found[2] > 1e-17


@pytest.mark.parametrize("modes", [0, 300, 301])
def test_too_many_modes(modes):
    with pytest.raises(InputError, match=f"{modes} modes asked of 300 points"):
        smallest_modes(ring(300), np.ones(300), modes)


def test_multiply_and_chebyshev(problem):
    stiffness, _, _ = problem
    random = np.random.default_rng(0)
    block, other = random.standard_normal((1500, 16)), random.standard_normal((1500, 16))
    assert multiply(stiffness, block) == pytest.approx(stiffness @ block)
    expected = 3 * (stiffness @ block - 0.5 * block) - other
    assert multiply(stiffness, block, 3.0, 0.5, other) == pytest.approx(expected)
    values, vectors = np.linalg.eigh(stiffness.toarray())
    edge, top = values[40], 1.01 * values[-1]
    mapped = np.polynomial.chebyshev.Chebyshev.basis(5)((2 * values - top - edge) / (top - edge))
    expected = vectors @ (mapped[:, None] * (vectors.T @ block))
    assert chebyshev(stiffness, block, 5, edge, top) == pytest.approx(expected)


def test_known_vectors_are_left_out(problem):
    stiffness, _, _ = problem
    values, vectors = np.linalg.eigh(stiffness.toarray())
    found, _, _ = filtered_lanczos(stiffness, 20, vectors[:, :7], 1e-8)
    assert found == pytest.approx(values[7:27], abs=1e-9)


@pytest.mark.uncompiled
def test_products_of_rows_with_many_and_few_entries():
    """Eight entries at a time, then the rest; the last row has none."""
    random = np.random.default_rng(0)
    dense = random.standard_normal((30, 30)) * (random.random((30, 30)) < np.linspace(1, 0, 30)[:, None])
    block, other = random.standard_normal((2, 30, 16))
    assert multiply(csr_array(dense), block) == pytest.approx(dense @ block)
    expected = 3 * (dense @ block - 0.5 * block) - other
    assert multiply(csr_array(dense), block, 3.0, 0.5, other) == pytest.approx(expected)
