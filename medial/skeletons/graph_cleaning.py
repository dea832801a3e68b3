"""From the first graph of a skeleton to a clean one: collapsed to curves, zipped, bridged, stubs cut.

All functions change the graph in place. Its nodes have ``members`` (ids of points), a ``place`` and a
``radius``.
"""

from collections.abc import Iterator
from itertools import pairwise

import networkx as nx
import numpy as np
from numpy.typing import NDArray

Float = NDArray[np.float64]

HANDLE = 6.0
"""A loop shorter than this many radii of the body around it is no handle: those have more than 2 pi."""
BESIDE = 0.5
"""A node within this many radii of an edge that ends at its neighbour, too, lies on it."""
SPECK = 0.02
"""Share of the points below which a node by itself is dropped."""
GAP = 2.0
"""Longest bridge between two parts, over the sum of the radii at its ends."""
AHEAD = 0.5
"""Least cosine between a bridge and the branch that it continues."""
STUB = 1.5
"""A branch of which no node is farther than this many radii from the rest of the skeleton is none."""


def place_of(graph: nx.Graph, node: int) -> Float:
    """Position of a node, (3,)."""
    found: Float = graph.nodes[node]["place"]
    return found


def radius_of(graph: nx.Graph, node: int) -> float:
    """Radius of the body around a node."""
    return float(graph.nodes[node]["radius"])


def edge_length(graph: nx.Graph, a: int, b: int) -> float:
    """Distance of two nodes."""
    return float(np.linalg.norm(place_of(graph, a) - place_of(graph, b)))


def collapsed(graph: nx.Graph) -> None:
    """Remove triangles and short loops: their shortest edges are collapsed, one after another."""
    while True:
        triangles = {edge for edge in graph.edges if any(True for _ in nx.common_neighbors(graph, *edge))}
        edges = triangles or _of_short_loops(graph)
        best = min(edges, key=lambda edge: (edge_length(graph, *edge), *sorted(edge)), default=None)
        if best is None:
            return
        _collapse(graph, *sorted(best))


def _of_short_loops(graph: nx.Graph) -> list[tuple[int, int]]:
    """Edges of the shortest loop, if it is too short to be a handle of the body."""
    if nx.number_of_edges(graph) < nx.number_of_nodes(graph):
        parts = nx.number_connected_components(graph)
        if nx.number_of_edges(graph) == nx.number_of_nodes(graph) - parts:
            return []
    short = []
    for loop in nx.minimum_cycle_basis(graph):
        edges = sorted(graph.subgraph(loop).edges)
        length = sum(edge_length(graph, *edge) for edge in edges)
        if length < HANDLE * float(np.mean([radius_of(graph, k) for k in loop])):
            short.append((length, edges))
    return min(short)[1] if short else []


def _collapse(graph: nx.Graph, a: int, b: int) -> None:
    """Merge the second node into the first: their mean, weighted by their points."""
    one, two = graph.nodes[a], graph.nodes[b]
    share = len(two["members"]) / (len(one["members"]) + len(two["members"]))
    one["place"] = (1 - share) * one["place"] + share * two["place"]
    one["radius"] = (1 - share) * one["radius"] + share * two["radius"]
    one["members"] = np.concatenate([one["members"], two["members"]])
    others = [k for k in graph.neighbors(b) if k != a]
    graph.remove_node(b)
    graph.add_edges_from((a, k) for k in others)


def zipped(graph: nx.Graph) -> None:
    """Lay edges beside each other into one chain.

    Where two edges leave a node and the end of one lies on the other, the longer one begins at that end
    instead. All edges together become shorter, so this ends.
    """
    waiting = sorted(graph.nodes)
    while waiting:
        node = waiting.pop()
        step = next(_strands(graph, node), None)
        if step is None:
            continue
        near, far = step
        graph.remove_edge(node, far)
        graph.add_edge(near, far)
        waiting += [near, far, node]


def _strands(graph: nx.Graph, node: int) -> Iterator[tuple[int, int]]:
    """Pairs of neighbours (a, b) such that a lies on the edge from the node to b."""
    around = sorted(graph.neighbors(node))
    for a in around:
        for b in around:
            if a == b or edge_length(graph, node, a) > edge_length(graph, node, b):
                continue
            way = place_of(graph, b) - place_of(graph, node)
            offset = place_of(graph, a) - place_of(graph, node)
            share = offset @ way / max(float(way @ way), 1e-300)
            beside = float(np.linalg.norm(offset - np.clip(share, 0, 1) * way))
            reach = BESIDE * min(radius_of(graph, a), radius_of(graph, b))
            if 0 < share <= 1 and beside < reach and edge_length(graph, a, b) < edge_length(graph, node, b):
                yield a, b


def bridged(graph: nx.Graph) -> None:
    """Join parts across gaps in the scan, the shortest gap first.

    A bridge is no longer than `GAP` times the radii at its ends, and goes on, at one end at least, in the
    direction in which a branch ends there.
    """
    while True:
        parts = [sorted(part) for part in nx.connected_components(graph)]
        best = None
        for k, part in enumerate(parts):
            for other in parts[:k]:
                best = min(filter(None, (best, _best_bridge(graph, part, other))), default=None)
        if best is None:
            return
        graph.add_edge(best[1], best[2])


def _best_bridge(graph: nx.Graph, part: list[int], other: list[int]) -> tuple[float, int, int] | None:
    """The shortest bridge between two parts that is allowed, with its length before it."""
    here, there = (np.array([place_of(graph, k) for k in each]) for each in (part, other))
    gaps = np.linalg.norm(here[:, None] - there, axis=2)
    sizes = [np.array([radius_of(graph, k) for k in each]) for each in (part, other)]
    for at in np.argsort(gaps, axis=None, kind="stable"):
        i, j = np.unravel_index(at, gaps.shape)
        if gaps[i, j] > GAP * (sizes[0].max() + sizes[1].max()):
            return None
        a, b = part[i], other[j]
        near = gaps[i, j] <= GAP * (sizes[0][i] + sizes[1][j])
        if near and (_goes_on(graph, a, b) or _goes_on(graph, b, a)):
            return float(gaps[i, j]), a, b
    return None


def _goes_on(graph: nx.Graph, tip: int, goal: int) -> bool:
    """Whether a branch ends at a node, and the way to another one leads on in its direction."""
    around = list(graph.neighbors(tip))
    if len(around) != 1:
        return not around
    along = place_of(graph, tip) - place_of(graph, around[0])
    way = place_of(graph, goal) - place_of(graph, tip)
    return bool(along @ way >= AHEAD * np.linalg.norm(along) * np.linalg.norm(way))


def without_specks(graph: nx.Graph) -> None:
    """Drop parts of one node with few points, unless nothing else is there; the nearest node gets these."""
    total = sum(len(graph.nodes[k]["members"]) for k in graph.nodes)
    lone = sorted(k for k in graph.nodes if graph.degree[k] == 0)
    specks = [k for k in lone if len(graph.nodes[k]["members"]) < SPECK * total]
    rest = sorted(set(graph.nodes) - set(specks))
    for speck in specks if rest else ():
        nearest = graph.nodes[min(rest, key=lambda k: (edge_length(graph, speck, k), k))]
        nearest["members"] = np.concatenate([nearest["members"], graph.nodes[speck]["members"]])
        graph.remove_node(speck)


def pruned(graph: nx.Graph) -> None:
    """Cut stubs: branches that end within the body's radius around the rest, the shortest first.

    The points of a stub go to its junction.
    """
    while True:
        stubs = []
        for tip in sorted(k for k in graph.nodes if graph.degree[k] == 1):
            branch = _branch_of(graph, tip)
            if branch is not None and _is_stub(graph, branch):
                stubs.append((sum(edge_length(graph, *edge) for edge in pairwise(branch)), branch))
        if not stubs:
            return
        branch = min(stubs)[1]
        goal = graph.nodes[branch[-1]]
        goal["members"] = np.concatenate([graph.nodes[k]["members"] for k in reversed(branch)])
        graph.remove_nodes_from(branch[:-1])


def _is_stub(graph: nx.Graph, branch: list[int]) -> bool:
    """Whether a branch, from tip to junction, lies within the body around the rest of the skeleton."""
    rest = graph.subgraph(nx.node_connected_component(graph, branch[-1]) - set(branch[:-1]))
    start, end = (np.array([place_of(graph, edge[side]) for edge in rest.edges]) for side in (0, 1))
    sizes = np.array([[radius_of(graph, a), radius_of(graph, b)] for a, b in rest.edges])
    way = end - start
    for node in branch[:-1]:
        offset = place_of(graph, node) - start
        share = np.clip((offset * way).sum(axis=1) / np.maximum((way**2).sum(axis=1), 1e-300), 0, 1)
        away = np.linalg.norm(offset - share[:, None] * way, axis=1)
        if (away >= STUB * (sizes[:, 0] + share * (sizes[:, 1] - sizes[:, 0]))).all():
            return False
    return True


def _branch_of(graph: nx.Graph, tip: int) -> list[int] | None:
    """Nodes from a tip to the first junction; None if there is none."""
    branch, before = [tip], None
    while True:
        ways = [k for k in graph.neighbors(branch[-1]) if k != before]
        if len(branch) > 1 and graph.degree[branch[-1]] > 2:
            return branch
        if not ways:
            return None
        before = branch[-1]
        branch.append(ways[0])
