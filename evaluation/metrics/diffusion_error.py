r"""Eq. 18: how much missing data and pose change the diffusion m_t.

The well-sampled rest pose P and a scan Q are compared through the ground truth f, which is exact: a scan
point knows its face and barycentrics, and the same face and barycentrics on the rest mesh is f(x).
Between the samples of P its eigenfunctions are interpolated (`interpolation`), at a sample itself
exactly, so P against itself is 0.

Units: m_t has units of one over area. Both m_t are multiplied by the area of the reference mesh, which makes
the error independent of the units of length, unless the operators were built without the departure
`eq18_area_factor`. Nothing else is normalised in ``eq18``. Further columns give the same error with each m_t
divided by the heat trace of its own cloud, as Sec. 4 does for matching (``eq18_trace``), and relative to the
size of the reference's m_t (``eq18_relative``).

Times: both clouds use one set, taken from the spectrum of P (`medial.spectrum.times`), so that all scans of
one subject share it.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from datasets_gen.records import InputError
from datasets_gen.values import check_count, check_seed
from medial import Diffusion
from medial.departures import Departures
from medial.diffusion import decay
from medial.matching.common_units import check_comparable, rescaled
from medial.spectrum.times import TIMES, logarithmic_times

PAIRS = 10_000
"""|C| of Eq. 18."""
NEIGHBOURS = 4


@dataclass(frozen=True)
class Stability:
    """Errors of one cloud against the reference.

    Attributes
    ----------
    eq18 : float
        Eq. 18 of the dimensionless kernel (area of the reference) * m_t.
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
    scale: float = 1.0,
    departures: Departures | None = None,
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
    scale
        Lengths of the cloud over those of the reference: 1000 for millimetres and a mesh in metres.
    departures
        Those that the reference was built with if not given. Without `eq18_area_factor`, m_t keeps its unit,
        one over area, and `area` is not used.

    Raises
    ------
    InputError
        If the operators or their settings differ, or the arrays do not belong to the cloud.
    """
    check_comparable(reference, cloud, "compare")
    cloud = cloud if scale == 1 else rescaled(cloud, 1 / scale)
    if canonical.shape != (len(cloud), 3) or canonical_normals.shape != (len(cloud), 3):
        raise InputError(f"canonical points {canonical.shape} do not belong to a cloud of {len(cloud)}")
    scales = logarithmic_times(reference.eigenvalues, count=times)
    factor = area if (departures or reference.departures).eq18_area_factor else 1.0
    x, y = np.random.default_rng(check_seed(seed)).integers(len(cloud), size=(2, check_count(pairs, "pairs")))
    carry = interpolation(reference.points, reference.normals, canonical, canonical_normals)
    here = factor * kernel_of_pairs(cloud.eigenfunctions, cloud.eigenvalues, x, y, scales)
    carried = carry @ reference.eigenfunctions
    there = factor * kernel_of_pairs(carried, reference.eigenvalues, x, y, scales)
    per_time = kernel_error(here, there)
    traced = kernel_error(here / cloud.heat_trace(scales), there / reference.heat_trace(scales))
    size = np.linalg.norm(there, axis=0) / pairs
    return Stability(
        eq18=float(per_time.mean()),
        eq18_trace=float(traced.mean()),
        eq18_relative=float((per_time / size).mean()),
        times=scales,
        per_time=per_time,
    )


def kernel_error(here: NDArray[np.float64], there: NDArray[np.float64]) -> NDArray[np.float64]:
    r"""Eq. 18: the error in medial diffusion, term by term; their mean over the times is E(P, Q).

    .. math::

        E(P, Q) = \frac{1}{|C|\, |T|} \sum_{t \in T}
        \left( \sum_{(x, y) \in C} |m_t(x, y) - m_t(f(x), f(y))|^2 \right)^{1/2}

    As written, a term is the norm over the pairs divided by their number, so that it falls as 1 / sqrt(|C|):
    values compare at one |C| only.

    In the code (`diffusion_error`): m_t is multiplied by the area of the reference mesh, so that the error
    has no unit; and between the samples of P, m_t(f(x), f(y)) is interpolated.

    Parameters
    ----------
    here : (pairs, T)
        m_t(x, y) on Q for the pairs C and the times, in one over area.
    there : (pairs, T)
        m_t(f(x), f(y)) on P.

    Returns
    -------
    (T,) in the unit of m_t
    """
    return np.asarray(np.linalg.norm(here - there, axis=0) / len(here))


def kernel_of_pairs(
    eigenfunctions: NDArray[np.float64],
    eigenvalues: NDArray[np.float64],
    x: NDArray[np.integer],
    y: NDArray[np.integer],
    times: NDArray[np.float64],
) -> NDArray[np.float64]:
    """m_t(x, y) of Eq. 13 for pairs of points and several times, (pairs, T)."""
    return (eigenfunctions[x] * eigenfunctions[y]) @ decay(eigenvalues, times)
