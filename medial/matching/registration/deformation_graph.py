r"""Deformations of a cloud that bend but hardly stretch: rigid motions of nodes, blended [SSP07].

Node j at rest in g_j carries a rotation R_j and a position y_j; a point x follows its nearest nodes,

    x' = sum_j w_j(x) (R_j (x - g_j) + y_j).

Nodes are near in the *diffusion map*, not in space alone (`medial.matching.neighbourhoods`). For the medial
operator a node is a piece of a limb with all its sides, so that a side without data follows the sides that
have some, and a hand does not stick to the hip beside it. Neighbouring nodes should agree on where both of
them go and on how they turn. Unknown are six numbers per node, found by Gauss-Newton steps with one banded
Cholesky factor each.

References
----------
[SSP07] Sumner, Schmid, Pauly: Embedded deformation for shape manipulation. SIGGRAPH 2007.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, reverse_cuthill_mckee

from medial.matching.landmarks.samples import farthest_points
from medial.matching.registration import kernels as kernels

Float = NDArray[np.float64]
Float32 = NDArray[np.float32]
Int = NDArray[np.int64]

INFLUENCES = 4
"""Nodes that move a point, unless told otherwise. More of them tie together what lies side by side."""
SHARED = 0.02
"""Nodes are neighbours when they share this part of a node's points."""
BEND = 0.03
"""Disagreement of neighbours beyond which it costs linearly, in sqrt(area)."""
ELASTIC = 1.25
"""Edges may grow by this factor, around the outside of a joint for instance."""
TORN = 0.25
"""Further growth, relative to the edge, at which it is half torn."""
SHORT = 0.04
"""Edges shorter than this, in sqrt(area), count as this long."""
BRIDGE = 0.05
"""Weight of the edges that join nodes which share no points, relative to the mean mass of a node."""


@dataclass(frozen=True)
class Attachment:
    """How n points hang on nodes: ids and weights, (n, influences); weights sum to 1."""

    nodes: Int
    weights: Float

    def rows(self, index: Int) -> "Attachment":
        """The attachment of some of the points."""
        return Attachment(self.nodes[index], self.weights[index])

    def spread(self, rows: Int, values: Float) -> Float:
        """Values (r,) of some of the points, averaged at the nodes and from there at all points, (n,)."""
        hang = self.rows(rows)
        count = int(self.nodes.max()) + 1
        mass = np.bincount(hang.nodes.ravel(), hang.weights.ravel(), count)
        total = np.bincount(hang.nodes.ravel(), (hang.weights * values[:, None]).ravel(), count)
        return self.at_points(total / np.maximum(mass, np.finfo(float).tiny))

    def at_points(self, values: Float) -> Float:
        """Values of the nodes (N,) blended at the points, (n,)."""
        return np.asarray((values[self.nodes] * self.weights).sum(axis=1))


@dataclass(frozen=True)
class Pose:
    """Where the nodes are: rotations (N, 3, 3) and positions (N, 3)."""

    rotations: Float
    positions: Float

    def mixed(self, other: "Pose", nodes: Int) -> "Pose":
        """The pose with some nodes taken from another one."""
        rotations, positions = self.rotations.copy(), self.positions.copy()
        rotations[nodes], positions[nodes] = other.rotations[nodes], other.positions[nodes]
        return Pose(rotations, positions)


@dataclass(frozen=True)
class NodeGraph:
    """Nodes over a cloud and how strongly neighbours hold together.

    Attributes
    ----------
    coordinates : (N, d) float32
        Of the nodes (`medial.matching.neighbourhoods`).
    rest : (N, 3) float64
        Mean of each node's points.
    edges : (E, 2) int64
    hold : (E,) float64
        Weights of the edges; their sum is 1.
    reach : float
        Typical radius of a node's points: what turns rotations into lengths.
    """

    coordinates: Float32
    rest: Float
    edges: Int
    hold: Float
    reach: float

    @classmethod
    def over(
        cls, coordinates: Float32, points: Float, eligible: Int, count: int, influences: int = INFLUENCES
    ) -> tuple["NodeGraph", Attachment]:
        """Nodes far apart in the neighbourhoods, and how the points hang on them.

        Parameters
        ----------
        coordinates : (n, d)
        points : (n, 3)
        eligible : (e,) int64
            Points that may become nodes: representative ones, as the farthest of all points are outliers.
        count
            Number of nodes; at most e.
        influences
            Nodes that move a point.
        """
        remote = int((coordinates[eligible] ** 2).sum(axis=1).argmax())
        ids = eligible[farthest_points(coordinates[eligible], count, remote)]
        anchors, used = coordinates[ids], np.zeros(1, dtype=bool)
        while not used.all():  # of nodes at one place only some get points
            attachment = attach(coordinates, anchors, influences)
            share = shares(attachment, len(anchors))
            mass = share.sum(axis=0)
            used = mass > 1e-9 * mass.max()
            anchors = anchors[used]
        rest = (share.T @ points) / mass[:, None]
        spread = (share.T @ (points**2).sum(axis=1)) / mass - (rest**2).sum(axis=1)
        reach = float(np.sqrt(np.median(np.maximum(spread, 0))))
        overlap = (share.T @ share).toarray()
        edges, hold = _edges(overlap / mass.mean(), anchors)
        order = _along_the_body(overlap, edges)
        rank = np.argsort(order)
        edges = np.sort(rank[edges], axis=1)
        rows = np.lexsort(edges.T[::-1])
        graph = cls(anchors[order], rest[order], edges[rows], hold[rows], reach)
        return graph, Attachment(rank[attachment.nodes], attachment.weights)

    def __len__(self) -> int:
        """Return the number of nodes."""
        return len(self.rest)

    def parts(self, nodes: NDArray[np.bool_]) -> list[Int]:
        """Connected parts of a subset of the nodes."""
        inside = self.edges[nodes[self.edges].all(axis=1)]
        graph = coo_array((np.ones(len(inside)), (inside[:, 0], inside[:, 1])), shape=(len(self),) * 2)
        _, label = connected_components(graph, directed=False)
        return [np.flatnonzero(nodes & (label == k)) for k in np.unique(label[nodes])]

    def held(self, pose: Pose) -> Float:
        """Share of the body that each node still holds on to, (N,), relative to the best; 1 if nothing tore.

        Limbs bend, but their joints do not stretch: what hangs on the rest by torn edges only is misplaced.
        Two nodes hold on to each other as the weakest edge of the best path between them does.
        """
        i, j = self.edges.T
        before = np.linalg.norm(self.rest[i] - self.rest[j], axis=1)
        after = np.linalg.norm(pose.positions[i] - pose.positions[j], axis=1)
        growth = np.maximum(after - ELASTIC * before, 0) / np.maximum(before, SHORT)
        strength = 1 / (1 + (growth / TORN) ** 2)
        share = kernels.strongest_paths(len(self), self.edges, strength).mean(axis=1)
        return np.asarray(share / share.max())

    def strain(self, pose: Pose) -> float:
        """Weighted mean square disagreement of neighbours, in squared units of length."""
        size = 6 * len(self)
        return self.add_edges(np.zeros((size, size)), np.zeros(size), pose, 1.0)

    def add_edges(self, system: Float, right: Float, pose: Pose, weight: float) -> float:
        """Add the edges' normal equations, times `weight`; return the strain."""
        turn, place = pose.rotations, pose.positions
        return float(
            kernels.add_edges(
                system, right, self.edges, self.hold, self.rest, turn, place, self.reach, weight, BEND
            )
        )


def attach(coordinates: Float32, anchors: Float32, influences: int = INFLUENCES) -> Attachment:
    """Hang points on their nearest nodes; the weight falls to 0 at the next one.

    Parameters
    ----------
    coordinates : (n, d)
    anchors : (N, d)
    influences
        Nodes that move a point; fewer if there are fewer.
    """
    square = np.einsum("nd,nd->n", coordinates, coordinates)[:, None] - 2 * coordinates @ anchors.T
    square += np.einsum("nd,nd->n", anchors, anchors)
    count = min(influences, len(anchors) - 1)
    order = np.sort(np.argpartition(square, count, axis=1)[:, : count + 1], axis=1)
    near = np.argsort(np.take_along_axis(square, order, axis=1), axis=1, kind="stable")
    order = np.take_along_axis(order, near, axis=1)
    gap = np.sqrt(np.maximum(np.take_along_axis(square, order, axis=1), 0)).astype(np.float64)
    weights = np.maximum(1 - gap[:, :count] / np.maximum(gap[:, count:], 1e-12), 1e-3)
    return Attachment(order[:, :count].astype(np.int64), weights / weights.sum(axis=1, keepdims=True))


def shares(attachment: Attachment, count: int) -> csr_array:
    """Weights as a sparse matrix, (n, N)."""
    n, influences = attachment.nodes.shape
    start = influences * np.arange(n + 1)
    return csr_array((attachment.weights.ravel(), attachment.nodes.ravel(), start), shape=(n, count))


def _along_the_body(overlap: Float, edges: Int) -> Int:
    """Order of the nodes in which those that share points or an edge have numbers close to each other."""
    joined = overlap > 0
    joined[edges[:, 0], edges[:, 1]] = joined[edges[:, 1], edges[:, 0]] = True
    return np.asarray(reverse_cuthill_mckee(csr_array(joined), symmetric_mode=True), dtype=np.int64)


def _edges(overlap: Float, anchors: Float32) -> tuple[Int, Float]:
    """Neighbours (sharing points, or the three nearest) and weights; connected."""
    count = len(anchors)
    pairs = {(int(i), int(j)): overlap[i, j] for i, j in np.argwhere(np.triu(overlap, 1) > SHARED)}
    gap = np.linalg.norm(anchors[:, None] - anchors, axis=2)
    np.fill_diagonal(gap, np.inf)
    for i, near in enumerate(np.argsort(gap, axis=1, kind="stable")[:, :3]):
        for j in near:
            pairs.setdefault((min(i, int(j)), max(i, int(j))), BRIDGE)
    while True:
        edges = np.array(sorted(pairs))
        graph = coo_array((np.ones(len(edges)), (edges[:, 0], edges[:, 1])), shape=(count, count))
        parts, label = connected_components(graph, directed=False)
        if parts == 1:
            break
        apart = np.where((label[:, None] == 0) & (label != 0), gap, np.inf)
        first, second = divmod(int(apart.argmin()), count)
        pairs[(min(first, second), max(first, second))] = BRIDGE
    hold = np.array([pairs[(int(i), int(j))] for i, j in edges])
    return edges.astype(np.int64), hold / hold.sum()


def solve(system: Float, right: Float) -> Float:
    """Solution of the (slightly damped) normal equations; only the lower triangle is read."""
    system[np.diag_indices_from(system)] += 1e-6 * np.trace(system) / len(system) + 1e-12
    return -kernels.cholesky_solve(system, right)


class NormalEquations:
    """Gauss-Newton step of a pose: pull the points, then `step`.

    Parameters
    ----------
    graph
    pose
    points : (n, 3)
        At rest.
    attachment
        Of the points.
    """

    def __init__(self, graph: NodeGraph, pose: Pose, points: Float, attachment: Attachment) -> None:
        self._graph, self._pose, self._points, self._attachment = graph, pose, points, attachment
        self._metric, self._force = np.zeros((len(points), 3, 3)), np.zeros((len(points), 3))

    def pull(self, rows: Int, offset: Float, normals: Float, even: Float, along: Float) -> None:
        """Pull some of the points: even |offset|^2 + along (n . offset)^2.

        Parameters
        ----------
        rows : (m,) int64
            The points; they may repeat.
        offset : (m, 3)
            From the goal to where the point is now.
        normals : (m, 3)
            At the goal.
        even, along : (m,)
            Weights.
        """
        kernels.add_pulls(self._metric, self._force, rows, offset, normals, even, along)

    def step(self, stiffness: float) -> Pose:
        """The pose after one step, in which neighbouring nodes hold together with a weight."""
        size = 6 * len(self._graph)
        system, right = np.zeros((size, size)), np.zeros(size)
        turn, nodes, weights = self._pose.rotations, self._attachment.nodes, self._attachment.weights
        kernels.add_points(
            system, right, self._points, nodes, weights, self._graph.rest, turn, self._metric, self._force
        )
        self._graph.add_edges(system, right, self._pose, stiffness)
        change = solve(system, right).reshape(-1, 6)
        return Pose(kernels.turned(turn, change[:, :3]), self._pose.positions + change[:, 3:])


def moved(
    points: Float, directions: Float, attachment: Attachment, graph: NodeGraph, pose: Pose
) -> tuple[Float, Float]:
    """Points (n, 3) and unit directions (n, 3) that hang on nodes, in a pose."""
    return kernels.moved(
        points, directions, attachment.nodes, attachment.weights, graph.rest, pose.rotations, pose.positions
    )
