"""Processor seconds, eigenvalue errors and residuals of the sensible eigensolvers on one operator.

python -m tests.benchmarks.operator_solvers POINTS [MODES]             the medial operator: no cheap factors
python -m tests.benchmarks.operator_solvers POINTS [MODES] --tufted    the tufted Laplacian: sparse factors
"""

import sys
import time
import warnings

import numpy as np
from scipy.sparse import csc_array, csr_array, diags_array, eye_array
from scipy.sparse.linalg import LinearOperator, eigsh, lobpcg, splu

from medial.laplacian.tufted import tufted_laplacian
from medial.operator import Operator, build_operator
from medial.spectrum.modes import smallest_modes, symmetric_form
from medial.validation import check_cloud
from tests.benchmarks.operator_stages import scanned


def timed(name, function, matrix, exact=None):
    """Time a solver that returns eigenvalues and orthonormal eigenvectors of the symmetric form."""
    start = time.process_time()
    values, vectors = function()
    seconds = time.process_time() - start
    order = np.argsort(values)
    values, vectors = values[order], vectors[:, order]
    top = float(abs(matrix).sum(axis=1).max())
    residual = np.linalg.norm(matrix @ vectors - vectors * values, axis=0).max() / top
    error = "" if exact is None else f"   largest error of an eigenvalue {np.abs(values - exact).max():.1e}"
    sys.stdout.write(f"{name:<44}{seconds:8.2f} s   residual {residual:.1e}{error}\n")
    sys.stdout.flush()
    return values


def ours(stiffness, areas, modes, **options):
    values, functions, _ = smallest_modes(stiffness, areas, modes, **options)
    return values, functions * np.sqrt(areas)[:, None]


def filtered(points, modes):
    """The medial operator: about a hundred entries a row."""
    stiffness, areas, _, _ = build_operator(check_cloud(*scanned(points)), Operator())
    matrix = symmetric_form(stiffness, 1 / np.sqrt(areas))
    smallest_modes(stiffness, areas, 20)
    top = float(eigsh(matrix, 1, which="LA", return_eigenvectors=False)[0]) * 1.01
    flipped = csr_array(top * eye_array(points) - matrix)
    start = np.random.default_rng(0).standard_normal((points, modes))

    def from_the_top():
        values, vectors = eigsh(flipped, modes, tol=1e-6, v0=start[:, 0])
        return top - values, vectors

    def shifted():
        return eigsh(csc_array(matrix), modes, sigma=-1e-3, tol=1e-6, v0=start[:, 0])

    def preconditioned():
        jacobi = diags_array(1 / matrix.diagonal())
        with warnings.catch_warnings(action="ignore"):  # it does not converge
            return lobpcg(matrix, start, M=jacobi, largest=False, tol=1e-5, maxiter=60)

    exact = timed("filtered block Lanczos (ours)", lambda: ours(stiffness, areas, modes), matrix)
    timed("eigsh, top - M", from_the_top, matrix, exact)
    timed("eigsh(sigma)", shifted, matrix, exact)
    timed("lobpcg, Jacobi", preconditioned, matrix, exact)


def inverted(points, modes):
    """The tufted Laplacian: seven entries a row."""
    stiffness, areas = tufted_laplacian(scanned(points)[0])
    matrix = symmetric_form(stiffness, 1 / np.sqrt(areas))
    constant = np.sqrt(areas / areas.sum())
    shift = 1e-6 * float(np.median(matrix.diagonal()))
    start = np.random.default_rng(0).standard_normal(points)

    def deflated():
        """The zero mode of the one component is taken out of the inverse."""
        shifted = csc_array(matrix + shift * eye_array(points))
        factors = splu(shifted, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True})

        def solve(vector):
            vector = vector.ravel() - constant * (constant @ vector.ravel())
            solved = factors.solve(vector)
            return solved - constant * (constant @ solved)

        inverse = LinearOperator((points, points), matvec=solve, dtype=float)
        own = start - constant * (constant @ start)
        values, vectors = eigsh(matrix, modes - 1, sigma=-shift, OPinv=inverse, tol=1e-6, v0=own)
        return np.append(0.0, values), np.column_stack([constant, vectors])

    def plain():
        return eigsh(csc_array(matrix), modes, sigma=-shift, tol=1e-6, v0=start)

    smallest_modes(stiffness, areas, 20, factorise=True)
    exact = timed(
        "inverse block Lanczos (ours)", lambda: ours(stiffness, areas, modes, factorise=True), matrix
    )
    timed("eigsh(sigma), zero mode deflated", deflated, matrix, exact)
    timed("eigsh(sigma)", plain, matrix, exact)


def main(arguments):
    numbers = [int(each) for each in arguments if each.isdigit()]
    points, modes = [*numbers, 300][:2]
    (inverted if "--tufted" in arguments else filtered)(points, modes)


if __name__ == "__main__":
    main(sys.argv[1:])
