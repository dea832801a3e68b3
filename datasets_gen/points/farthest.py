"""Farthest-point order: each point is the one that is farthest from all points chosen before it.

Three functions, by what is known of the points. `farthest_points` serves scans: three coordinates, large
clouds, any start. `farthest_in_embedding` takes any number of coordinates, starts at a given point and can
keep away from others. `farthest_in_metric` asks for distances, along a graph for instance.

`fpsample` cannot replace `farthest_in_embedding`: it takes up to eight coordinates, and counts its start in
the order of its tree. On scans, from one start, both choose the same points but for ties of rounding, and
fpsample is faster: ``python -m tests.benchmarks.farthest_order``.
"""

from collections.abc import Callable

import fpsample
import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled

Float32 = NDArray[np.float32]
Int = NDArray[np.int64]

TREE_HEIGHT = 7
"""Of fpsample's bucket tree on clouds large enough for it; about the fastest for 1e4..1e6 points."""
SLACK = 1.001
"""Squared distances are rounded to single precision by less than this factor."""
FAR, LARGE = 64.0, 1e15
"""Clouds farther than this from the origin, over their extent, or of an extent beyond this or below its
inverse, are brought to the unit cube: fpsample has single precision."""


def farthest_points(points: NDArray[np.float64], n: int, start: int) -> NDArray[np.int64]:
    """Indices of a farthest-point sample of a cloud, in the order of choice.

    Parameters
    ----------
    points : (m, d)
        At most eight coordinates.
    n
        Number of points to choose, 1..m.
    start
        Where the choice begins: fpsample counts points in the order of its tree.

    Returns
    -------
    (n,) int64
        Distinct, even where points coincide.
    """
    low, high = points.min(axis=0), points.max(axis=0)
    extent = float((high - low).max())
    if np.abs(low + high).max() > 2 * FAR * extent or not 1 / LARGE < extent < LARGE:
        points = (points - low) / (extent or 1.0)
    height = min(TREE_HEIGHT, int(np.log2(len(points))))
    if height < 1:
        return np.zeros(n, np.int64)  # a single point
    order = fpsample.bucket_fps_kdline_sampling(points, n, h=height, start_idx=start).astype(np.int64)
    first = np.sort(np.unique(order, return_index=True)[1])
    if len(first) == n:
        return order
    rest = np.setdiff1d(np.arange(len(points)), order)  # fewer places than points asked for
    return np.concatenate([order[first], rest[: n - len(first)]])


def farthest_in_metric(
    distances_from: Callable[[int], NDArray[np.float64]], count: int, start: int
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Farthest-point order for distances of any kind, path lengths for instance.

    Parameters
    ----------
    distances_from
        Distances of all n points from one, (n,); infinite where there is no path.
    count
        How many points to choose; no more than n.
    start
        First point.

    Returns
    -------
    order : (count,) int64
        Starts with `start`.
    distances : (count, n) float64
        Of all points from each of these.
    """
    order, rows = [int(start)], [distances_from(int(start))]
    nearest = rows[0]
    while len(order) < min(count, len(nearest)):
        order.append(int(nearest.argmax()))
        rows.append(distances_from(order[-1]))
        nearest = np.minimum(nearest, rows[-1])
    return np.array(order, dtype=np.int64), np.array(rows)


def farthest_from_mean(points: NDArray[np.float64], count: int) -> NDArray[np.int64]:
    """Farthest-point order from the point farthest from the mean.

    Parameters
    ----------
    points : (n, d)
    count
        How many points to choose; no more than n.

    Returns
    -------
    (count,) int64
    """
    centred = points - points.mean(axis=0)
    return farthest_in_embedding(centred, count, int((centred**2).sum(axis=1).argmax()))


def farthest_in_embedding(
    embedding: NDArray[np.floating], count: int, start: int, chosen: NDArray[np.integer] | None = None
) -> NDArray[np.int64]:
    """Farthest-point order in a Euclidean space of any dimension.

    Parameters
    ----------
    embedding : (n, d)
        Compared in single precision; of equally far points the first is taken.
    count
        How many points to choose; no more than n.
    start
        First point.
    chosen
        Points to keep away from as well.

    Returns
    -------
    (count,) int64
        Distinct; starts with `start`.
    """
    x = np.ascontiguousarray(embedding, dtype=np.float32)
    away = np.array([] if chosen is None else chosen, dtype=np.int64)
    return np.asarray(_farthest_in_cells(x, min(count, len(x)), start, away))


@compiled()
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
def _farthest_in_cells(x: Float32, count: int, start: int, away: Int) -> Int:
    """Greedy order; a chosen point is nearest to the points of its cell, and knows the farthest of them.

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
