"""Where joints are: where the lines of their branches meet, as centres within a joint are of no limb."""

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from medial.skeletons.graph_cleaning import place_of, radius_of

Float = NDArray[np.float64]

OUTSIDE = 1.5
"""Radii of the body from a joint to where a branch has a centre line of its own."""
FARTHEST = 1.5
"""Radii by which a joint moves at most."""
CROSSING = 0.1
"""Least eigenvalue of the lines' equations, per line, from which they cross: less is parallel."""


def settled_joints(graph: nx.Graph) -> None:
    """Move each joint to where its branches, as lines from outside it, meet best; in place.

    Nodes between it and the lines' ends move onto straight ways to it.
    """
    for joint in sorted(k for k in graph.nodes if graph.degree[k] > 2):
        ways = [_way_out(graph, joint, first) for first in sorted(graph.neighbors(joint))]
        lines = [(place_of(graph, way[-2]), place_of(graph, way[-1])) for way in ways if len(way) > 2]
        middle = _meeting(lines)
        if middle is None:
            continue
        step = middle - place_of(graph, joint)
        length = float(np.linalg.norm(step))
        limit = FARTHEST * radius_of(graph, joint)
        graph.nodes[joint]["place"] = place_of(graph, joint) + step * min(1, limit / max(length, 1e-300))
        for way in ways:
            _straighten(graph, way[:-1])


def _way_out(graph: nx.Graph, joint: int, first: int) -> list[int]:
    """Nodes from a joint along a branch to the first outside it and, if there is one, the next after that."""
    way = [joint, first]
    while graph.degree[way[-1]] == 2:
        away = np.linalg.norm(place_of(graph, way[-1]) - place_of(graph, joint))
        beyond = next(k for k in graph.neighbors(way[-1]) if k != way[-2])
        if beyond in way:
            break
        way.append(beyond)
        if away > OUTSIDE * radius_of(graph, joint):
            return way
    return [joint]


def _meeting(lines: list[tuple[Float, Float]]) -> Float | None:
    """The place nearest to lines through two places each; None if they do not cross."""
    if len(lines) < 2:
        return None
    starts = np.array([start for start, _ in lines])
    along = np.array([end - start for start, end in lines])
    along /= np.maximum(np.linalg.norm(along, axis=1, keepdims=True), 1e-300)
    across = np.eye(3) - np.einsum("li,lj->lij", along, along)
    total = across.sum(axis=0)
    if np.linalg.eigvalsh(total)[0] < CROSSING * len(lines):
        return None
    return np.asarray(np.linalg.solve(total, np.einsum("lij,lj->i", across, starts)))


def _straighten(graph: nx.Graph, way: list[int]) -> None:
    """Project the inner nodes of a way onto the segment between its ends."""
    if len(way) < 3:
        return
    start, end = place_of(graph, way[0]), place_of(graph, way[-1])
    along = end - start
    for node in way[1:-1]:
        share = float((place_of(graph, node) - start) @ along) / max(float(along @ along), 1e-300)
        graph.nodes[node]["place"] = start + np.clip(share, 0, 1) * along
