r"""Eq. 18: how much missing data and pose change the diffusion m_t.

The well-sampled rest pose P and a scan Q are compared through the ground truth f, which is exact: a scan
point knows its face and barycentrics, and the same face and barycentrics on the rest mesh is f(x).
Between the samples of P its eigenfunctions are interpolated (`interpolation`), at a sample itself
exactly, so P against itself is 0.

Units and normalisation: m_t has units of one over area. Both m_t are multiplied by the area of the reference
mesh, which makes the error independent of the units of length; nothing else is normalised in ``eq18``. As
further columns the same error is given with each m_t divided by the heat trace of its own cloud, as Sec.
4 does for matching (``eq18_trace``), and relative to the size of the reference's m_t (``eq18_relative``).

Times: both clouds use one set, taken from the spectrum of P, so that all scans of one subject share it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from datasets_gen.records import InputError
from medial import Diffusion
from medial.diffusion import decay

PAIRS = 10_000
"""|C| of Eq. 18."""
TIMES = 25
NEIGHBOURS = 4
_CONNECTED = 1e-9  # eigenvalues below this share of the largest are the zeros of separate components


@dataclass(frozen=True)
class Stability:
    """Errors of one cloud against the reference.

    Attributes
    ----------
    eq18 : float
        Eq. 18 as written, of the dimensionless kernel (area of the reference) * m_t.
    eq18_trace : float
        The same with each m_t divided by the heat trace of its cloud at t.
    eq18_relative : float
        Mean over times of |m_t - m_t(f, f)| / |m_t(f, f)|, norms over the pairs.
    times : (T,) float64
    per_time : (T,) float64
        Terms of Eq. 18: their mean is `eq18`.
    """

    eq18: float
    eq18_trace: float
    eq18_relative: float
    times: NDArray[np.float64]
    per_time: NDArray[np.float64]


def time_scales(eigenvalues: NDArray[np.float64], count: int = TIMES) -> NDArray[np.float64]:
    """Logarithmic times from 4 ln 10 / lambda_max to 4 ln 10 / lambda_2 [SOG09], (count,).

    lambda_2 is the smallest eigenvalue that is not the 0 of a separate component.

    Raises
    ------
    InputError
        If no eigenvalue is positive.
    """
    positive = eigenvalues[eigenvalues > _CONNECTED * eigenvalues.max()]
    if not len(positive) or not positive[-1] > 0:
        raise InputError("the operator has no positive eigenvalue: no time scales; use more modes")
    span = 4 * np.log(10)
    return np.geomspace(span / positive.max(), span / positive.min(), count)


def interpolation(
    samples: NDArray[np.float64],
    sample_normals: NDArray[np.float64],
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
) -> csr_array:
    """Weights that carry values from samples of a surface to other points of it, (points, samples).

    Inverse squared distances over the nearest samples that face the same way, so that values do not leak
    through thin parts; a point that is a sample takes its value exactly.

    Parameters
    ----------
    samples, sample_normals : (m, 3)
    points, normals : (n, 3)

    Returns
    -------
    csr_array (n, m)
        Rows sum to 1.
    """
    k = min(4 * NEIGHBOURS, len(samples))
    distances, ids = cKDTree(samples).query(points, k=k)
    distances, ids = distances.reshape(len(points), k), ids.reshape(len(points), k)
    facing = np.einsum("nkd,nd->nk", sample_normals[ids], normals) > 0
    facing[~facing.any(axis=1)] = True  # no neighbour faces the same way: take them all
    facing &= np.cumsum(facing, axis=1) <= NEIGHBOURS
    scale = distances[:, -1:] + np.finfo(float).tiny
    weights = np.where(facing, 1 / ((distances / scale) ** 2 + 1e-300), 0.0)
    exact = (distances <= 1e-12 * scale) & facing
    weights = np.where(exact.any(axis=1, keepdims=True), exact, weights)
    weights /= weights.sum(axis=1, keepdims=True)
    indptr = np.arange(0, len(points) * k + 1, k)
    return csr_array((weights.ravel(), ids.ravel(), indptr), shape=(len(points), len(samples)))


def diffusion_error(
    reference: Diffusion,
    cloud: Diffusion,
    canonical: NDArray[np.float64],
    canonical_normals: NDArray[np.float64],
    area: float,
    *,
    pairs: int = PAIRS,
    times: int = TIMES,
    seed: int = 0,
) -> Stability:
    """Eq. 18 of a cloud against the well-sampled reference.

    Parameters
    ----------
    reference
        Diffusion of the well-sampled rest pose.
    cloud
        Diffusion of the scan, with the same operator.
    canonical : (n, 3)
        f(x): the cloud's points carried to the rest pose.
    canonical_normals : (n, 3)
        Outward normals of the rest pose there.
    area
        Surface area of the rest pose, which makes m_t dimensionless.
    pairs, times
        |C| and |T|.
    seed
        Draws the pairs.

    Raises
    ------
    InputError
        If the operators differ or the arrays do not belong to the cloud.
    """
    if reference.operator != cloud.operator:
        raise InputError(f"cannot compare a {reference.operator!r} with a {cloud.operator!r} diffusion")
    if canonical.shape != (len(cloud), 3) or canonical_normals.shape != (len(cloud), 3):
        raise InputError(f"canonical points {canonical.shape} do not belong to a cloud of {len(cloud)}")
    scales = time_scales(reference.eigenvalues, times)
    x, y = np.random.default_rng(seed).integers(len(cloud), size=(2, pairs))
    carry = interpolation(reference.points, reference.normals, canonical, canonical_normals)
    here = area * kernel_of_pairs(cloud.eigenfunctions, cloud.eigenvalues, x, y, scales)
    carried = carry @ reference.eigenfunctions
    there = area * kernel_of_pairs(carried, reference.eigenvalues, x, y, scales)
    per_time = np.linalg.norm(here - there, axis=0) / pairs
    traced = here / cloud.heat_trace(scales) - there / reference.heat_trace(scales)
    size = np.linalg.norm(there, axis=0) / pairs
    return Stability(
        eq18=float(per_time.mean()),
        eq18_trace=float((np.linalg.norm(traced, axis=0) / pairs).mean()),
        eq18_relative=float((per_time / size).mean()),
        times=scales,
        per_time=per_time,
    )


def kernel_of_pairs(
    eigenfunctions: NDArray[np.float64],
    eigenvalues: NDArray[np.float64],
    x: NDArray[np.integer],
    y: NDArray[np.integer],
    times: NDArray[np.float64],
) -> NDArray[np.float64]:
    """m_t(x, y) of Eq. 13 for pairs of points and several times, (pairs, T)."""
    return (eigenfunctions[x] * eigenfunctions[y]) @ decay(eigenvalues, times)
