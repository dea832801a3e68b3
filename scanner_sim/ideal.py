"""The complete sampling of a surface: the well-sampled rest pose of Eq. 18."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.points.farthest import farthest_points
from datasets_gen.records import InputError
from datasets_gen.shape import Shape
from datasets_gen.values import check_count, check_seed
from scanner_sim.scan import Scan
from scanner_sim.scanner_config import ScannerConfig
from scanner_sim.tracing.surface_points import corner_normals, shading_normals

OVERSAMPLING = 5
"""Uniform samples drawn per point kept."""


def sample(shape: Shape, n: int, seed: int = 0, shading: str = "smooth") -> Scan:
    """Sample the whole surface evenly, as an ideal scanner would.

    Uniform samples by area are thinned to `n` by farthest-point sampling.

    Parameters
    ----------
    shape
    n
        Number of points, at least 1.
    seed
    shading
        True normals: ``"smooth"`` (interpolated vertex normals) or ``"flat"`` (of the faces).

    Returns
    -------
    Scan
        With intensity 1, view -1 and pixels (-1, -1); its points are the true ones.

    Raises
    ------
    InputError
        If `n` is less than 1 or the shape has no area.
    """
    n, seed = check_count(n, "points"), check_seed(seed)
    rng = np.random.default_rng(seed)
    face_ids, barycentrics = uniform(shape, OVERSAMPLING * n, rng)
    points = shape.at(face_ids, barycentrics)
    start = int(rng.integers(len(points)))
    kept = farthest_points(points, n, start)
    face_ids, barycentrics, points = face_ids[kept], barycentrics[kept], points[kept]
    return Scan(
        points=points,
        normals=shading_normals(corner_normals(shape, shading), face_ids, barycentrics),
        face_ids=face_ids,
        barycentrics=barycentrics,
        true_points=points,
        intensity=np.ones(n),
        view_ids=np.full(n, -1, np.int32),
        pixels=np.full((n, 2), -1, np.int32),
        width=np.zeros(n),
        angle=np.zeros(n),
        shape_name=shape.name,
        config=ScannerConfig(),
        seed=seed,
    )


def uniform(shape: Shape, n: int, rng: np.random.Generator) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
    """Random surface points, uniform by area.

    Parameters
    ----------
    shape
    n
        Number of points.
    rng

    Returns
    -------
    face_ids : (n,) int32
    barycentrics : (n, 3) float64

    Raises
    ------
    InputError
        If the shape has no area.
    """
    areas = shape.face_areas
    if not areas.sum() > 0:
        raise InputError(f"shape {shape.name!r} has no area to sample")
    face_ids = rng.choice(len(areas), size=n, p=areas / areas.sum()).astype(np.int32)
    root, v = np.sqrt(rng.random(n)), rng.random(n)
    return face_ids, np.stack([1 - root, root * (1 - v), root * v], axis=1)


def coverage(scan: Scan, shape: Shape, radius: float | None = None, samples: int = 50_000) -> float:
    """Share of the surface area within a distance of the nearest scanned surface point.

    Distances are measured from the true points, so noise does not count as missing data;
    ``1 - coverage`` is the missing fraction.

    Parameters
    ----------
    scan
        A scan of `shape`.
    shape
    radius
        In mesh units; 1 % of the diagonal of the surface's bounding box if not given.
    samples
        Random surface points that measure the area; the standard error is below ``0.5 / sqrt(samples)``.

    Returns
    -------
    float
        In [0, 1].

    Raises
    ------
    InputError
        If the radius is not positive.
    """
    if radius is None:
        radius = 0.01 * shape.diagonal
    if not radius > 0:
        raise InputError(f"coverage radius must be positive, got {radius!r}")
    if len(scan) == 0:
        return 0.0
    probes = shape.at(*uniform(shape, samples, np.random.default_rng(0)))
    nearest, _ = cKDTree(scan.true_points).query(probes, distance_upper_bound=radius)
    return float(np.isfinite(nearest).mean())
