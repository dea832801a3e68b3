"""Samples spread evenly over a cloud: clusters and farthest points in an embedding."""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError
from medial.diffusion import Diffusion
from medial.nearest import nearest

LOG_DECADES = 4 * np.log(10)
"""4 ln 10 of [SOG09]: the time at which a mode has decayed by four decades is this over its eigenvalue."""


def first_positive_mode(eigenvalues: NDArray[np.float64]) -> int:
    """Index of the first eigenvalue that is not zero (one zero per connected component).

    Raises
    ------
    InputError
        If all eigenvalues are zero.
    """
    positive = np.flatnonzero(eigenvalues > 1e-8 * eigenvalues[-1])
    if eigenvalues[-1] <= 0 or len(positive) == 0:
        raise InputError(
            f"no positive eigenvalue among {len(eigenvalues)} modes; use a larger cloud or more modes"
        )
    return int(positive[0])


def diffusion_map(diffusion: Diffusion, time: float) -> NDArray[np.float64]:
    """Coordinates whose Euclidean distance is the diffusion distance at a time: exp(-lambda t) psi.

    Parameters
    ----------
    diffusion
    time
        Diffusion time, in the reciprocal unit of the eigenvalues.

    Returns
    -------
    (n, k) float64
        Constant modes are kept: with several components they tell the components apart.
    """
    return diffusion.eigenfunctions * np.exp(-diffusion.eigenvalues * time)


def smallest_time(diffusion: Diffusion) -> float:
    """Time at which the highest mode has decayed by four decades: 4 ln 10 / lambda_max [SOG09]."""
    return float(LOG_DECADES / diffusion.eigenvalues[-1])


def farthest_points(
    embedding: NDArray[np.floating], count: int, start: int, chosen: NDArray[np.integer] | None = None
) -> NDArray[np.int64]:
    """Greedy farthest-point order in a Euclidean embedding.

    Parameters
    ----------
    embedding : (n, d)
    count
        How many points to pick; no more than n.
    start
        First point.
    chosen
        Points to stay away from as well.

    Returns
    -------
    (count,) int64
        Starts with `start`.
    """
    x = np.ascontiguousarray(embedding, dtype=np.float32)
    square = np.einsum("nd,nd->n", x, x)
    count = min(count, len(x))
    order = np.empty(count, dtype=np.int64)
    gap = np.full(len(x), np.inf, dtype=np.float32)
    for other in () if chosen is None else chosen:
        np.minimum(gap, square + square[other] - 2 * (x @ x[other]), out=gap)
    point = start
    for k in range(count):
        order[k] = point
        np.minimum(gap, square + square[point] - 2 * (x @ x[point]), out=gap)
        gap[point] = -np.inf
        point = int(gap.argmax())
    return order


def spectral_samples(diffusion: Diffusion, count: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Points evenly spaced over medial regions: one per cluster of the diffusion map (Sec. 4, [BS12]).

    As `cluster_samples`, at the smallest time.
    """
    return cluster_samples(diffusion_map(diffusion, smallest_time(diffusion)), count, rng)


def cluster_samples(
    coordinates: NDArray[np.floating], count: int, rng: np.random.Generator, iterations: int = 5
) -> NDArray[np.int64]:
    """One point per cluster.

    k-means from farthest-point seeds; each cluster is represented by the point nearest to its mean.

    Parameters
    ----------
    coordinates : (n, d)
    count
        Number of samples; clouds with fewer points are returned whole.
    rng
        Draws the first seed.
    iterations
        Rounds of k-means.

    Returns
    -------
    (min(count, n),) int64
        Distinct point ids, ascending.
    """
    n = len(coordinates)
    if count >= n:
        return np.arange(n, dtype=np.int64)
    x = coordinates.astype(np.float32)
    means = x[farthest_points(x, count, int(rng.integers(n)))]
    for _ in range(iterations):
        label, _ = nearest(x, means)
        means = _cluster_means(x, label, means)
    label, gap = nearest(x, means)
    order = np.lexsort((gap, label))  # the first point of each cluster is the nearest to its mean
    _, first = np.unique(label[order], return_index=True)
    samples = order[first]
    missing = count - len(samples)
    if missing:  # clusters that ran empty: fill up where the samples are sparse
        fill = farthest_points(x, missing + 1, int(samples[0]), chosen=samples)[1:]
        samples = np.union1d(samples, fill)
    return np.sort(samples).astype(np.int64)


def _cluster_means(
    x: NDArray[np.float32], label: NDArray[np.int64], means: NDArray[np.float32]
) -> NDArray[np.float32]:
    """Mean of each cluster; an empty cluster keeps its old mean."""
    order = np.argsort(label, kind="stable")
    present, start, size = np.unique(label[order], return_index=True, return_counts=True)
    updated = means.copy()
    updated[present] = np.add.reduceat(x[order], start, axis=0) / size[:, None].astype(np.float32)
    return updated
