"""Cut-off, single precision and 300 modes change Eq. 18 by less than 1 %."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import eigh
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from medial import Diffusion, density_weights, dual_areas, medial_axis, surface_areas
from medial.areas.dual_area import JOINED, calibrated
from medial.areas.surface_cells import REFERENCE_POINTS
from medial.laplacian.weights import combine, diffusion_rates, gaussian_weights, laplacian
from medial.similarity.candidate_ball import smallest_width
from medial.similarity.equations import similarity_matrix
from medial.spectrum.times import logarithmic_times
from tests.medial import clouds

PAIRED = 400
"""Points of a cloud, all pairs of which are compared."""


def exact(points, normals):
    """The default operator with every similarity, in double precision, and every mode."""
    surface = surface_areas(points, normals)
    cap, mass = smallest_width(points), density_weights(surface)
    phi = csr_array(similarity_matrix(points, normals, r_cap=cap, weights=mass))
    centers, radii = medial_axis(points, normals, phi)
    areas = calibrated(dual_areas(points, centers, radii, normals, JOINED), surface)
    alpha, bandwidths = gaussian_weights(points, surface)
    sigma = combine(phi, alpha, areas, 0.5, diffusion_rates(bandwidths, surface.sum(), REFERENCE_POINTS))
    values, vectors = eigh(laplacian(sigma, areas).toarray(), np.diag(areas))
    return Diffusion(points, normals, areas, np.maximum(values, 0), vectors, centers, radii, "medial")


def truncated(diffusion, modes):
    values, functions = diffusion.eigenvalues[:modes], diffusion.eigenfunctions[:, :modes]
    return replace(diffusion, eigenvalues=values, eigenfunctions=functions)


def stability_error(reference, other, times):
    """Eq. 18; the nearest point of the reference stands for the same surface point."""
    chosen = np.arange(0, len(other.points), max(1, len(other.points) // PAIRED))
    same = cKDTree(reference.points).query(other.points[chosen])[1]
    total = sum(
        np.linalg.norm(other.kernel(t, chosen, chosen) - reference.kernel(t, same, same)) for t in times
    )
    return total / (len(chosen) ** 2 * len(times))


@pytest.mark.parametrize("points", [700, pytest.param(2000, marks=[pytest.mark.slow, pytest.mark.long])])
def test_default_settings_keep_the_value_of_equation_18(points):
    shapes = clouds.body(points), clouds.body(int(0.8 * points), holes=8)
    truth = [exact(*shape) for shape in shapes]
    fast = [Diffusion.from_points(*shape, modes=300) for shape in shapes]
    times = logarithmic_times(truncated(truth[0], 300).eigenvalues)
    assert stability_error(*fast, times) == pytest.approx(stability_error(*truth, times), rel=0.01)
    assert fast[0].eigenvalues[1:] == pytest.approx(truth[0].eigenvalues[1:300], rel=1e-4)
