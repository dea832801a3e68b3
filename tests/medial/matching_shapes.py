"""Small oriented clouds with known correspondences, and their tufted-Laplacian diffusions."""

import numpy as np
import robust_laplacian
import scipy.sparse.linalg
from skimage.measure import marching_cubes

from medial import Diffusion


def lobes(arms, resolution=26, sharpness=14.0):
    """Closed smooth surface around segments (start, end, radius): a smooth union of capsules.

    Returns points and outward normals.
    """
    axes = [np.linspace(-1.7, 1.7, resolution)] * 3
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)
    total = np.zeros(grid.shape[:3])
    for start, end, radius in arms:
        a, b = np.asarray(start, float), np.asarray(end, float)
        t = np.clip((grid - a) @ (b - a) / ((b - a) @ (b - a)), 0, 1)
        total += np.exp(-sharpness * (np.linalg.norm(grid - a - t[..., None] * (b - a), axis=-1) - radius))
    field = -np.log(total) / sharpness
    points, _, normals, _ = marching_cubes(field, 0.0, gradient_direction="ascent")
    step = axes[0][1] - axes[0][0]
    return points * step - 1.7, -normals


UNEQUAL_ARMS = (
    ((0, 0, 0), (1.3, 0, 0), 0.22),
    ((0, 0, 0), (-0.6, 0.9, 0), 0.3),
    ((0, 0, 0), (-0.3, -1.2, 0.2), 0.26),
    ((0, 0, 0), (0.1, 0.1, 0.9), 0.34),
)


def diffusion_of(points, normals, modes=60):
    laplacian, mass = robust_laplacian.point_cloud_laplacian(points)
    areas = mass.diagonal()
    start = np.ones(len(points))
    values, vectors = scipy.sparse.linalg.eigsh(laplacian.tocsc(), modes, mass.tocsc(), sigma=-1e-6, v0=start)
    vectors /= np.sqrt(areas @ vectors**2)
    return Diffusion(
        points, normals, areas, np.maximum(values, 0), vectors, points, np.zeros(len(points)), "robust"
    )


def unequal_arms(modes=60, resolution=26):
    return diffusion_of(*lobes(UNEQUAL_ARMS, resolution), modes=modes)


def permuted(diffusion, seed=0, rotation=None):
    """The same cloud in another order, optionally rotated; order[i] is the old id of point i."""
    order = np.random.default_rng(seed).permutation(len(diffusion))
    turn = np.eye(3) if rotation is None else rotation
    sign = np.random.default_rng(seed + 1).choice([-1.0, 1.0], diffusion.eigenfunctions.shape[1])
    return order, Diffusion(
        diffusion.points[order] @ turn.T,
        diffusion.normals[order] @ turn.T,
        diffusion.areas[order],
        diffusion.eigenvalues,
        diffusion.eigenfunctions[order] * sign,
        diffusion.centers[order] @ turn.T,
        diffusion.radii[order],
        diffusion.operator,
    )
