"""The operator of the paper from its equations alone: Eqs. 4-15, one line each, for a few hundred points.

A reader's entry, and what ``Diffusion.from_points(..., departures="none")`` is tested against.
`docs/paper.md` lists all equations.
"""

from dataclasses import asdict

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import eigh

from medial.areas.equations import average_distance, dual_area, medial_averages, medial_neighbourhood
from medial.areas.surface_cells import surface_areas
from medial.departures import Departures
from medial.diffusion import Diffusion
from medial.laplacian.equations import combined_weights, gaussian, point_cloud_laplacian
from medial.similarity.equations import similarity_matrix

Array = NDArray[np.float64]


def medial_diffusion(
    points: Array, normals: Array, eta: float | None = 0.5, sigma_e: float = 5.0, sigma_t: float = 0.7
) -> Diffusion:
    """All eigenpairs of the point cloud Medial Laplacian.

    The paper leaves open two things: a point without a hull (Eq. 10) takes the area of its surface cell, and
    the bandwidth of the Gaussian (Eq. 2) is three times the mean of these areas.

    Parameters
    ----------
    points, normals : (n, 3)
        The cloud and its outward unit normals.
    eta
        Share of the Gaussian weights in Eq. 15; None takes phi alone (Eq. 8).
    sigma_e, sigma_t
        Tolerances of Eq. 7.

    Returns
    -------
    Diffusion
        With n modes.
    """
    cells = surface_areas(points, normals)
    phi = similarity_matrix(points, normals, sigma_e, sigma_t)
    centers, radii = medial_averages(points, normals, phi)
    epsilon = 1.5 * average_distance(points)
    areas = np.array(
        [
            dual_area(i, medial_neighbourhood(i, centers, epsilon), points, centers[i], radii[i])
            for i in range(len(points))
        ]
    )
    areas = np.where(areas > 0, areas, cells)
    weights = phi
    if eta is not None:
        weights = combined_weights(phi, gaussian(points, 3 * float(cells.mean())), areas, eta)
    columns = [point_cloud_laplacian(unit, weights, areas) for unit in np.eye(len(points))]
    symmetric = areas[:, None] * np.column_stack(columns)
    values, functions = eigh((symmetric + symmetric.T) / 2, np.diag(areas))
    made = {"eta": eta, "departures": asdict(Departures.none())}
    return Diffusion(points, normals, areas, np.maximum(values, 0), functions, centers, radii, "medial", made)
