"""Medial similarity phi between all pairs of points (Eqs. 4-7), in its fast form."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from datasets_gen.compiled import ranges
from datasets_gen.records import InputError
from medial.device.backend import CPU, backend, check_device
from medial.similarity.candidate_ball import SMALLEST_TANGENCY, smallest_width
from medial.similarity.candidate_pairs import Screen, candidate_pairs, make_screen
from medial.similarity.critical_radius import Grid, critical_grid
from medial.similarity.emptiness import Settings, similarities
from medial.similarity.every_pair import similar_among_all
from medial.similarity.leaves import LEAF, SortedCloud, kd_cloud
from medial.sparse import symmetric
from medial.validation import OrientedCloud, check_cloud

PAIRS_AT_ONCE = 10**8  # pairs of points examined before survivors are collected: bounds the memory
MOST_PAIRS = 2.5e8  # similar pairs that 8 GB hold


def similarity(
    points: NDArray[np.floating],
    normals: NDArray[np.floating],
    sigma_e: float = 5.0,
    sigma_t: float = 0.7,
    cutoff: float = 1e-6,
    *,
    r_cap: float | None = None,
    weights: NDArray[np.floating] | None = None,
    device: str = CPU,
) -> csr_array:
    """Medial similarity of all pairs of points (Eq. 7).

    Parameters
    ----------
    points, normals : (n, 3)
        The cloud and its outward unit normals.
    sigma_e, sigma_t
        Tolerance to points inside the ball (Eq. 5) and to tilt of the normals (Eq. 4).
    cutoff
        Smaller similarities are dropped, in (0, 1).
    r_cap
        Largest radius of a candidate ball, in the units of `points`; by default the smallest PCA width of the
        cloud. Eq. 6 measures depth relative to r, so without a cap enormous balls look empty. Infinity takes
        balls of any radius, on the processor and much more slowly (`similarity.every_pair`).
    weights : (n,), optional
        How much each point counts in Eq. 5; 1 by default, which is the paper's formula as written. See
        `medial.density_weights` for weights that make phi independent of the number of points.
    device : {"cpu", "cuda", "llvm"}
        Where it is computed (`medial.device`); the last digits depend on it.

    Returns
    -------
    (n, n) float64 csr_array
        Symmetric to the bit, zero diagonal. The same whatever the order of the points and the number of
        threads.

    Raises
    ------
    InputError
        If the arrays are not an oriented cloud, a parameter is out of range, the device is missing, or the
        cloud is so round that most pairs are similar and the result would not fit in memory.
    """
    cloud = check_cloud(points, normals)
    mass = np.ones(len(cloud)) if weights is None else np.ascontiguousarray(weights, dtype=np.float64)
    check_similarity(sigma_e, sigma_t, cutoff)
    check_device(device)
    _check_weights(mass, len(cloud))
    cap = smallest_width(cloud.points) if r_cap is None else float(r_cap)
    settings = Settings(float(sigma_e), float(sigma_t), -np.log(cutoff), cap, cutoff)
    return similarity_of(cloud, settings, mass, device)


def similarity_of(
    cloud: OrientedCloud, settings: Settings, mass: NDArray[np.float64], device: str = CPU
) -> csr_array:
    """`similarity` of a cloud and settings that have been checked.

    Parameters
    ----------
    cloud
    settings
        Tolerances, cut-off and radius cap.
    mass : (n,)
        How much each point counts in Eq. 5.
    device : {"cpu", "cuda", "llvm"}
    """
    n = len(cloud)
    jit = None if device == CPU else backend(device)
    extent = float(np.ptp(cloud.points, axis=0).max())
    if settings.cap <= 1e-9 * extent:
        return csr_array((n, n))  # a plane or a line: no ball fits below it
    if not np.isfinite(settings.cap):
        return _matrix(similar_among_all(cloud, settings, mass), n)
    tangency = max(2.0 - settings.sigma_t**2 * settings.budget / 4, SMALLEST_TANGENCY)
    ordered, order = kd_cloud(cloud.points, cloud.normals, mass)
    grid = critical_grid(ordered, settings.sigma_e * np.sqrt(settings.budget), tangency, settings.cap)
    screen = make_screen(ordered, grid, tangency, settings.cap)
    if jit is None:
        return _matrix(_similar_pairs(ordered, order, grid, screen, settings), n)
    from medial.device.pair_similarity import joined, similar_pairs  # imports Dr.Jit

    return joined(jit, _bounded(similar_pairs(jit, ordered, order, grid, screen, settings), n), n)


def _matrix(parts: Iterator[tuple[Any, Any, Any]], n: int) -> csr_array:
    """The (n, n) matrix of similar pairs (i, j, phi)."""
    found = _bounded(parts, n)
    i, j, phi = (np.concatenate([part[k] for part in found]) for k in range(3))
    return symmetric(i, j, phi, n)


def _bounded(parts: Iterator[tuple[Any, Any, Any]], n: int) -> list[tuple[Any, Any, Any]]:
    """All parts of the similar pairs (i, j, phi) of n points, if they fit in memory."""
    found, total = [], 0
    for part in parts:
        found.append(part)
        total += len(part[2])
        if total > MOST_PAIRS:
            raise InputError(
                f"more than {MOST_PAIRS:.3g} of the pairs of {n} points are similar: the shape is close to "
                "a ball; give fewer points or a larger cutoff"
            )
    return found


def _similar_pairs(
    cloud: SortedCloud, order: NDArray[np.int64], grid: Grid, screen: Screen, settings: Settings
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]]:
    """Pairs whose similarity reaches the cut-off, and it: a bounded number at a time."""
    for leaves in ranges(len(cloud.spheres), max(PAIRS_AT_ONCE // (len(cloud.x) * LEAF), 16)):
        pairs = candidate_pairs(grid, screen, leaves)
        values = similarities(cloud, grid, pairs, settings)
        kept = values >= settings.cutoff
        yield order[pairs.i[kept]], order[pairs.j[kept]], values[kept]


def check_similarity(sigma_e: float, sigma_t: float, cutoff: float) -> None:
    """Raise `InputError` if a parameter of Eq. 7 is out of range."""
    for name, value in (("sigma_e", sigma_e), ("sigma_t", sigma_t)):
        if not 0 < value < np.inf:
            raise InputError(f"{name} is {value!r}; give a positive number")
    if not 0 < cutoff < 1:
        raise InputError(f"cutoff is {cutoff!r}; choose it in (0, 1)")


def _check_weights(mass: NDArray[np.float64], n: int) -> None:
    if mass.shape != (n,) or not (np.isfinite(mass).all() and (mass >= 0).all()):
        raise InputError(f"weights must be {n} finite numbers >= 0, got shape {mass.shape}")
