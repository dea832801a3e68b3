"""Samples S_P and S_Q: one point per cluster of the diffusion map, or of other coordinates (Sec. 4)."""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.points.farthest import farthest_in_embedding
from medial.diffusion import Diffusion, decay
from medial.matching.nearest import nearest
from medial.spectrum.times import shortest_time

Int = NDArray[np.int64]


def diffusion_map(diffusion: Diffusion, time: float, rows: Int | slice = slice(None)) -> NDArray[np.float64]:
    """Coordinates whose Euclidean distance is the diffusion distance at a time: exp(-lambda t) psi.

    Parameters
    ----------
    diffusion
    time
        Diffusion time, in the reciprocal unit of the eigenvalues.
    rows
        Points wanted; all by default.

    Returns
    -------
    (rows, k) float64
        Constant modes are kept: with several components they tell the components apart.
    """
    return diffusion.eigenfunctions[rows] * decay(diffusion.eigenvalues, time)


def spectral_samples(diffusion: Diffusion, count: int, rng: np.random.Generator) -> NDArray[np.int64]:
    """Points evenly spaced over medial regions: one per cluster of the diffusion map (Sec. 4, [BS12]).

    As `cluster_samples`, at the shortest time.
    """
    return cluster_samples(diffusion_map(diffusion, shortest_time(diffusion.eigenvalues)), count, rng)


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
    means = x[farthest_in_embedding(x, count, int(rng.integers(n)))]
    for _ in range(iterations):
        label, _ = nearest(x, means)
        means = _cluster_means(x, label, means)
    label, gap = nearest(x, means)
    order = np.lexsort((gap, label))  # the first point of each cluster is the nearest to its mean
    _, first = np.unique(label[order], return_index=True)
    samples = order[first]
    missing = count - len(samples)
    if missing:  # clusters that ran empty: fill up where the samples are sparse
        fill = farthest_in_embedding(x, missing + 1, int(samples[0]), chosen=samples)[1:]
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
