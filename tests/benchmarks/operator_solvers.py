"""Processor seconds of the sensible eigensolvers on one medial operator.

python -m tests.benchmarks.operator_solvers POINTS [MODES]
"""

import sys
import time

import numpy as np
from scipy.sparse import csc_array, csr_array, diags_array, eye_array
from scipy.sparse.linalg import eigsh, lobpcg

from medial.areas.surface_cells import surface_areas
from medial.laplacian.weights import laplacian
from medial.operator import Operator, medial_weights
from medial.spectrum.modes import smallest_modes, symmetric_form
from tests.benchmarks.operator_stages import scanned


def timed(name, function, exact=None):
    start = time.process_time()
    values = np.sort(function())
    seconds = time.process_time() - start
    error = "" if exact is None else f"   largest error of an eigenvalue {np.abs(values - exact).max():.1e}"
    sys.stdout.write(f"{name:<44}{seconds:8.2f} s{error}\n")
    return values


def main(points, modes):
    cloud = scanned(points)
    weights, areas, _, _ = medial_weights(*cloud, surface_areas(*cloud), Operator())
    stiffness = laplacian(weights, areas)
    matrix = symmetric_form(stiffness, 1 / np.sqrt(areas))
    smallest_modes(stiffness, areas, 20)
    top = float(eigsh(matrix, 1, which="LA", return_eigenvectors=False)[0]) * 1.01
    flipped = csr_array(top * eye_array(points) - matrix)
    start = np.random.default_rng(0).standard_normal((points, modes))
    found = smallest_modes(stiffness, areas, modes)

    def cold():
        return smallest_modes(stiffness, areas, modes).eigenvalues

    exact = timed("filtered block Lanczos (ours)", cold)

    def warm():
        return smallest_modes(stiffness, areas, modes, start=found.eigenfunctions).eigenvalues

    def inverted():
        return eigsh(csc_array(matrix), modes, sigma=-1e-3, tol=1e-6, v0=start[:, 0])[0]

    def preconditioned():
        jacobi = diags_array(1 / matrix.diagonal())
        return lobpcg(matrix, start, M=jacobi, largest=False, tol=1e-5, maxiter=60)[0]

    timed("the same, started from its own result", warm, exact)
    timed("ARPACK, top - M", lambda: top - eigsh(flipped, modes, tol=1e-6, v0=start[:, 0])[0], exact)
    timed("ARPACK, shift and invert", inverted, exact)
    timed("LOBPCG, Jacobi", preconditioned, exact)


if __name__ == "__main__":
    main(int(sys.argv[1]), int(sys.argv[2]) if len(sys.argv) > 2 else 300)
