"""Pairs of points: how well they meet, how far they are apart, and who is nearest; compiled."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.compiled import compiled

Float = NDArray[np.float64]
Int = NDArray[np.int64]

FEW = 1000
"""Up to this number, places are compared one by one; of more, a tree finds the nearest."""
LEAF = 32
"""Places in a leaf of a tree."""


@compiled()
def meeting(points: Float, normals: Float, goals: Float, goal_normals: Float) -> tuple[Float, Float]:
    """Squared distances of points from their goals, and cosines of their normals, not below 0; (n,) each."""
    square, cosine = np.zeros(len(points)), np.zeros(len(points))
    for i in range(len(points)):
        dot = 0.0
        for r in range(3):
            square[i] += (points[i, r] - goals[i, r]) ** 2
            dot += normals[i, r] * goal_normals[i, r]
        cosine[i] = min(1.0, max(0.0, dot))
    return square, cosine


@compiled()
def mean_distance(points: Float, goals: Float) -> float:
    """Mean distance of points (n, 3) from their goals (n, 3)."""
    total = 0.0
    for i in range(len(points)):
        a, b, c = points[i, 0] - goals[i, 0], points[i, 1] - goals[i, 1], points[i, 2] - goals[i, 2]
        total += np.sqrt(a * a + b * b + c * c)
    return total / len(points)


@compiled()
def nearest_of_few(places: Float, goals: Float) -> Int:
    """Index of the place nearest to each goal, (g,); of equally near ones the first.

    Compares all pairs: for some hundred places faster than making a tree. The innermost loop runs over the
    goals, side by side.

    Parameters
    ----------
    places : (p, 6)
    goals : (g, 6)
    """
    a, b, c, d, e, f = [np.ascontiguousarray(goals[:, k]) for k in range(6)]
    index, least = np.zeros(len(goals), np.int64), np.full(len(goals), np.inf)
    for i in range(len(places)):
        u, v, w, x, y, z = places[i]
        for j in range(len(goals)):
            square = (a[j] - u) ** 2 + (b[j] - v) ** 2 + (c[j] - w) ** 2
            square += (d[j] - x) ** 2 + (e[j] - y) ** 2 + (f[j] - z) ** 2
            nearer = square < least[j]
            least[j] = square if nearer else least[j]
            index[j] = i if nearer else index[j]
    return index


class PlaceTree:
    """Places that are looked among often: each goal's nearest one.

    The nodes are those of scipy's tree, but know the box of their places, not only the plane between them. In
    six coordinates boxes exclude far more: ``python -m tests.benchmarks.place_tree`` compares times.

    Parameters
    ----------
    places : (p, 6)
        At least one.
    """

    def __init__(self, places: Float) -> None:
        tree = cKDTree(places, leafsize=LEAF)
        self._number = np.asarray(tree.indices, dtype=np.int64)
        self._places = np.ascontiguousarray(places[self._number], dtype=np.float64)
        self._nodes = _preorder(tree.tree)
        self._boxes = _boxes(self._places, self._nodes)

    def nearest(self, goals: Float) -> Int:
        """Index of the place nearest to each goal, (g,); of equally near ones any.

        Parameters
        ----------
        goals : (g, 6)

        Raises
        ------
        FloatingPointError
            If a goal is not finite.
        """
        if not np.isfinite(goals).all():
            raise FloatingPointError("a deformation left the finite numbers")
        return self._number[_nearest_in_boxes(goals, self._places, self._nodes, self._boxes)]


def _preorder(root: Any) -> Int:
    """Nodes of a tree, each followed by its first child: start and end of its places, and its second child.

    Returns
    -------
    (nodes, 3) int64
        A leaf has no second child: -1.
    """
    rows: list[list[int]] = []
    waiting = [(root, -1)]
    while waiting:
        node, parent = waiting.pop()
        if parent >= 0:
            rows[parent][2] = len(rows)
        if node.split_dim >= 0:
            waiting += [(node.greater, len(rows)), (node.lesser, -1)]
        rows.append([node.start_idx, node.end_idx, -1])
    return np.array(rows, dtype=np.int64)


@compiled()
def _boxes(places: Float, nodes: Int) -> Float:
    """The box of each node's places: least coordinates, then largest ones; (nodes, 12)."""
    boxes = np.empty((len(nodes), 12))
    for k in range(len(nodes) - 1, -1, -1):
        first, last, second = nodes[k]
        for r in range(6):
            low, high = places[first, r], places[first, r]
            if second < 0:
                for i in range(first + 1, last):
                    low, high = min(low, places[i, r]), max(high, places[i, r])
            else:
                low = min(boxes[k + 1, r], boxes[second, r])
                high = max(boxes[k + 1, 6 + r], boxes[second, 6 + r])
            boxes[k, r], boxes[k, 6 + r] = low, high
    return boxes


@compiled()
def _outside(goal: Float, box: Float) -> float:
    """Squared distance of a goal from a box."""
    square = 0.0
    for r in range(6):
        gap = max(box[r] - goal[r], goal[r] - box[6 + r], 0.0)
        square += gap * gap
    return square


@compiled()
def _nearest_in_boxes(goals: Float, places: Float, nodes: Int, boxes: Float) -> Int:
    """Position of the place nearest to each goal, (g,), in the order of the tree."""
    found = np.empty(len(goals), np.int64)
    waiting, bound = np.empty(len(nodes), np.int64), np.empty(len(nodes))
    for j in range(len(goals)):
        goal = goals[j]
        a, b, c, d, e, f = goal
        least, at = np.inf, 0
        count, waiting[0], bound[0] = 1, 0, 0.0
        while count > 0:
            count -= 1
            if bound[count] >= least:
                continue
            node, here = waiting[count], bound[count]
            while nodes[node, 2] >= 0 and here < least:
                near, far = node + 1, nodes[node, 2]
                here, there = _outside(goal, boxes[near]), _outside(goal, boxes[far])
                if there < here:
                    near, far, here, there = far, near, there, here
                if there < least:
                    waiting[count], bound[count] = far, there
                    count += 1
                node = near
            if here < least:
                for i in range(nodes[node, 0], nodes[node, 1]):
                    square = (places[i, 0] - a) ** 2 + (places[i, 1] - b) ** 2 + (places[i, 2] - c) ** 2
                    square += (places[i, 3] - d) ** 2 + (places[i, 4] - e) ** 2 + (places[i, 5] - f) ** 2
                    if square < least:
                        least, at = square, i
        found[j] = at
    return found


def nearest_places(places: Float, goals: Float) -> Int:
    """Index of the place nearest to each goal, (g,), where places (p, 6) are looked among but once."""
    if len(places) <= FEW:
        return np.asarray(nearest_of_few(places, goals))
    return PlaceTree(places).nearest(goals)
