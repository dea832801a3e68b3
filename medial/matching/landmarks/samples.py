"""Samples spread evenly over a cloud: clusters and farthest points in an embedding."""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled
from datasets_gen.records import InputError
from medial.diffusion import Diffusion, decay
from medial.matching.nearest import nearest

Float32 = NDArray[np.float32]
Int = NDArray[np.int64]

LOG_DECADES = 4 * np.log(10)
"""4 ln 10 of [SOG09]: the time at which a mode has decayed by four decades is this over its eigenvalue."""
SLACK = 1.001
"""Squared distances are rounded to single precision by less than this factor."""


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
    away = np.array([] if chosen is None else chosen, dtype=np.int64)
    return np.asarray(_farthest_points(x, min(count, len(x)), start, away))


@compiled(fastmath={"contract", "reassoc"})
def _square(a: Float32, b: Float32) -> np.float32:
    """Squared distance of two points."""
    total = np.float32(0)
    for k in range(len(a)):
        total += (a[k] - b[k]) ** 2
    return total


@compiled()
def _farthest(gap: Float32, points: Int) -> int:
    """The point of the largest gap; of equal ones the first."""
    best = points[0]
    for i in points:
        if gap[i] > gap[best] or (gap[i] == gap[best] and i < best):
            best = i
    return best


@compiled()
def _farthest_points(x: Float32, count: int, start: int, away: Int) -> Int:
    """Greedy order; a picked point is nearest to the points of its cell, and knows the farthest of them.

    A new one takes points only from cells whose own point is closer to it than twice their farthest one. All
    others are left alone.
    """
    n, most = len(x), count + len(away)
    order, gap = np.empty(count, np.int64), np.full(n, np.float32(np.inf))
    own, far = np.zeros(most + 1, np.int64), np.zeros(most + 1, np.int64)
    head, after = np.full(most + 1, -1), np.arange(1, n + 1)  # a cell is a linked list
    head[0], after[n - 1] = 0, -1  # in the first one are the points that are nearest to none yet
    for new in range(1, most + 1):
        if new <= len(away):
            point = away[new - 1]
            gap[point] = 0
        else:
            point = start if new == len(away) + 1 else _farthest(gap, far[:new])
            order[new - len(away) - 1], gap[point] = point, -np.inf
        own[new] = far[new] = point
        for cell in range(new):
            reach = gap[far[cell]] if far[cell] != point else np.float32(np.inf)
            if _square(x[point], x[own[cell]]) > 4 * SLACK * reach:
                continue
            i, head[cell], far[cell] = head[cell], -1, own[cell]
            while i >= 0:
                following, square = after[i], _square(x[point], x[i])
                to = new if square < gap[i] else cell
                gap[i] = min(gap[i], square)
                after[i], head[to] = head[to], i
                if gap[i] > gap[far[to]] or (gap[i] == gap[far[to]] and i < far[to]):
                    far[to] = i
                i = following
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
