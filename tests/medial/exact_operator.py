"""The operator of Eqs. 4-15 without cut-off, single precision or truncation, and Eq. 18 between two of them.

    python -m tests.medial.exact_operator [POINTS]

prints by how much each approximation changes the value of Eq. 18 (the table in `docs/operator.md`).
"""

import sys
from dataclasses import replace

import numpy as np
from scipy.linalg import eigh
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from medial import Diffusion, density_weights, medial_axis, surface_areas
from medial.areas.dual_area import calibrated, dual_areas
from medial.laplacian.weights import combine, diffusion_rates, gaussian_weights, laplacian
from medial.operator import NEAREST, REFERENCE_POINTS
from tests.medial import clouds, slow_medial


def exact(points, normals):
    """Every similarity in double precision, every mode."""
    surface = surface_areas(points, normals)
    mass = density_weights(surface)
    phi = csr_array(slow_medial.similarity(points, normals, cutoff=0, weights=mass))
    centers, radii = medial_axis(points, normals, phi)
    areas = calibrated(dual_areas(points, centers, radii, normals, NEAREST), surface)
    alpha, bandwidths = gaussian_weights(points, surface)
    sigma = combine(phi, alpha, areas, 0.5, diffusion_rates(bandwidths, surface.sum(), REFERENCE_POINTS))
    values, vectors = eigh(laplacian(sigma, areas).toarray(), np.diag(areas))
    return Diffusion(points, normals, areas, np.maximum(values, 0), vectors, centers, radii, "medial")


def truncated(diffusion, modes):
    return replace(
        diffusion,
        eigenvalues=diffusion.eigenvalues[:modes],
        eigenfunctions=diffusion.eigenfunctions[:, :modes],
    )


def times_of(diffusion, count=25):
    """Log-spaced times of [SOG09]."""
    first, last = diffusion.eigenvalues[[1, -1]]
    return np.geomspace(4 * np.log(10) / last, 4 * np.log(10) / first, count)


def stability_error(reference, other, times, pairs=400):
    """Eq. 18; the nearest point of the reference stands for the same surface point."""
    chosen = np.arange(0, len(other.points), max(1, len(other.points) // pairs))
    same = cKDTree(reference.points).query(other.points[chosen])[1]
    total = sum(
        np.linalg.norm(other.kernel(t, chosen, chosen) - reference.kernel(t, same, same)) for t in times
    )
    return total / (len(chosen) ** 2 * len(times))


def main(points):
    shapes = clouds.body(points), clouds.body(int(0.8 * points), holes=8)
    truth = [exact(*shape) for shape in shapes]
    times = times_of(truncated(truth[0], 300))
    wanted = stability_error(*truth, times)
    sys.stdout.write(f"{points} and {len(truth[1])} points, exact Eq. 18 = {wanted:.6g}\n")

    def row(name, one, other):
        error = stability_error(one, other, times) / wanted - 1
        values = np.abs(
            one.eigenvalues[1:300] / truth[0].eigenvalues[1 : len(one.eigenvalues)][:299] - 1
        ).max()
        sys.stdout.write(f"{name:<34} Eq. 18 {error:+.1e}   eigenvalues {values:.1e}\n")

    for cutoff in (1e-2, 1e-3, 1e-4, 1e-6, 1e-9):
        row(
            f"cut-off {cutoff:.0e}",
            *(Diffusion.from_points(*shape, modes=300, cutoff=cutoff) for shape in shapes),
        )
    for modes in (100, 200, 300, 500):
        row(f"exact, {modes} modes", *(truncated(each, modes) for each in truth))


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1500)
