"""Nearest neighbours, and graphs of them: a scan's gaps must not make its parts infinitely far."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from datasets_gen.compiled import ranges, run_tasks

ROWS_PER_TASK = 2048


def query_tree(
    tree: cKDTree, points: NDArray[np.floating], k: int = 1, within: float = np.inf
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Distances and ids of the nearest points in a tree, as ``tree.query`` gives them, on our threads.

    SciPy's own (``workers=``) go on writing into arrays that are freed when an exception, such as that of
    Ctrl-C, ends the wait for them: the process, or the notebook's kernel, crashes.

    Parameters
    ----------
    tree
    points : (n, d)
    k
        How many.
    within
        Largest distance.

    Returns
    -------
    (n,) or (n, k) float64, (n,) or (n, k) int64
        Infinity and the size of the tree where there is none.
    """
    spans = ranges(len(points), ROWS_PER_TASK) or [(0, 0)]
    parts = run_tasks(
        lambda start, stop: tree.query(points[start:stop], k=k, distance_upper_bound=within), spans
    )
    distances, ids = (np.concatenate(each) for each in zip(*parts, strict=True))
    return distances, ids


def neighbour_pairs(tree: cKDTree, neighbours: int) -> NDArray[np.int64]:
    """Pairs of nearest neighbours.

    Parameters
    ----------
    tree
        Of n points, in any number of dimensions.
    neighbours
        Nearest neighbours of each point that are paired with it; all others if there are fewer.

    Returns
    -------
    (E, 2) int64
        Each pair once, the smaller id first, in ascending order.
    """
    _, near = query_tree(tree, tree.data, min(neighbours + 1, tree.n))
    near = near.reshape(tree.n, -1)[:, 1:]
    pairs = np.column_stack([np.repeat(np.arange(tree.n), near.shape[1]), near.ravel()])
    return _unique(pairs)


def join_parts(
    pairs: NDArray[np.integer], positions: NDArray[np.floating], bridges: int = 1, hub: bool = False
) -> NDArray[np.int64]:
    """Connect a graph: join its parts by the shortest edges between them.

    With one bridge per gap this is the minimum spanning tree of the parts, whichever part is joined first.

    Parameters
    ----------
    pairs : (E, 2)
        Edges of a graph of n points.
    positions : (n, d)
        Between which the bridges are short.
    bridges
        Edges per gap, each from another point of the smaller part.
    hub
        Join every part to the largest one, and none to each other.

    Returns
    -------
    (E + bridges, 2) int64
        Each pair once, the smaller id first, in ascending order; no point is paired with itself.
    """
    pairs = _unique(pairs)
    count = len(positions)
    while True:
        graph = coo_array((np.ones(len(pairs)), (pairs[:, 0], pairs[:, 1])), shape=(count, count))
        parts, label = connected_components(graph, directed=False)
        if parts <= 1:
            return pairs
        size = np.bincount(label)
        main = label == size.argmax() if hub else label != size.argmin()
        there = np.flatnonzero(main)
        tree = cKDTree(positions[there])
        added = [pairs]
        for part in np.unique(label[~main]):
            here = np.flatnonzero(label == part)
            gap, closest = tree.query(positions[here])
            best = np.argsort(gap, kind="stable")[:bridges]
            added.append(np.column_stack([here[best], there[closest[best]]]))
        pairs = _unique(np.concatenate(added))


def _unique(pairs: NDArray[np.integer]) -> NDArray[np.int64]:
    """Each pair once, the smaller id first, in ascending order, without those of a point with itself."""
    pairs = np.asarray(pairs, dtype=np.int64).reshape(-1, 2)
    pairs = pairs[pairs[:, 0] != pairs[:, 1]]
    return np.unique(np.sort(pairs, axis=1), axis=0)
