"""Light that returns from below the surface: why marble, wax and skin are measured too deep.

The laser enters a translucent surface, is scattered once at some depth and leaves towards the camera, both
ways refracted; scans of marble are biased in this way by some 40 micrometres [GBR*01]. A camera ray at the
surface point x therefore sees the volume below x, lit by the sheet where it entered, beside x and nearer to
the laser. The peak's angle is that of the entry, so the triangulated point lies below the surface: on a plane
that faces the camera by ``d tan(a') / tan(a)`` for light from the depth d, with the angles a, a' of the laser
to the normal outside and inside; for small angles by the apparent depth d / n.

Depths are exponentially distributed. Light that is scattered more often, which blurs the sheet sideways too,
is left out.

References
----------
[GBR*01] G. Godin, J.-A. Beraldin, M. Rioux, M. Levoy, L. Cournoyer, F. Blais, "An assessment of laser range
measurement of marble surfaces", 5th Conference on Optical 3-D Measurement Techniques, 2001.
"""

import math

import numpy as np
from numpy.typing import NDArray

from datasets_gen.meshes.geometry import unit_vectors
from scanner_sim.scanner_config import ScannerConfig

NODES = 6
"""Depths per millimetre of `translucency`, and fewest; their stripes must overlap."""
MOST_NODES = 24
LEAST_COSINE = 0.02
"""Directions more oblique than this to the normal are taken to be as oblique."""


def refracted_slopes(
    directions: NDArray[np.float64], normals: NDArray[np.float64], refractive_index: float
) -> NDArray[np.float64]:
    """Sideways travel per depth below the surface of rays that enter it (Snell's law).

    Parameters
    ----------
    directions : (n, 3)
        Unit, into the surface.
    normals : (n, 3)
        Unit, outward.
    refractive_index
        Of the inside, relative to the outside.

    Returns
    -------
    (n, 3) float64
        Perpendicular to the normals; its length is the tangent of the refracted angle.
    """
    cosine = -np.einsum("nd,nd->n", directions, normals)
    along = directions + cosine[:, None] * normals
    sine = np.sqrt(1 - np.clip(cosine, LEAST_COSINE, 1) ** 2)
    along = along / np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-12)
    inside = sine / refractive_index
    return along * (inside / np.sqrt(1 - inside**2))[:, None]


def scattering_depths(mean: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Depths (q,) and weights (q,), summing to 1, of an exponential distribution: Gauss-Laguerre quadrature.

    Parameters
    ----------
    mean
        Mean depth, mm.
    """
    count = min(max(math.ceil(NODES * mean), NODES), MOST_NODES)
    nodes, weights = np.polynomial.laguerre.laggauss(count)
    return mean * nodes, weights / weights.sum()


def entry_points(
    points: NDArray[np.float64], normals: NDArray[np.float64], baseline: float, config: ScannerConfig
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Places where light that a camera ray sees below the surface has entered it.

    Seen through x, light from the depth d entered at ``x + d (c - t)``, with the `refracted_slopes` c of the
    camera ray and t of the laser's, both at x: the surface is taken to be flat over the depth.

    Parameters
    ----------
    points : (n, 3)
        x: where the camera rays meet the surface, in camera coordinates, mm.
    normals : (n, 3)
        Unit, outward.
    baseline
        x coordinate of the laser, mm.
    config

    Returns
    -------
    places : (n, q, 3) float64
        For q depths.
    weights : (q,) float64
        Share of the light from each depth; they sum to 1.
    """
    laser = points - np.array([baseline, 0.0, 0.0])
    seen = refracted_slopes(unit_vectors(points), normals, config.refractive_index)
    lit = refracted_slopes(unit_vectors(laser), normals, config.refractive_index)
    depths, weights = scattering_depths(config.translucency)
    return points[:, None] + depths[:, None] * (seen - lit)[:, None], weights
