r"""Deformations of a cloud that bend but hardly stretch: rigid motions of nodes, blended [SSP07].

Node j at rest in g_j carries a rotation R_j and a position y_j; a point x follows its nearest nodes::

    x' = sum_j w_j(x) (R_j (x - g_j) + y_j).

Nodes are near in the *diffusion map*, not in space alone (`medial.matching.neighbourhoods`). For the medial
operator a node is a piece of a limb with all its sides, so that a side without data follows the sides that
have some, and a hand does not stick to the hip beside it. Neighbouring nodes should agree on where both of
them go and on how they turn. Unknown are six numbers per node, found by Gauss-Newton steps
(`registration.normal_equations`).

References
----------
[SSP07] Sumner, Schmid, Pauly: Embedded deformation for shape manipulation. SIGGRAPH 2007.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array
from scipy.sparse.csgraph import connected_components, reverse_cuthill_mckee
from scipy.spatial import cKDTree

from datasets_gen.points.farthest import farthest_in_embedding
from datasets_gen.points.neighbours import join_parts, neighbour_pairs
from medial.matching.registration.blending import blend
from medial.matching.registration.energy_terms import add_edges, strain_of_edges
from medial.matching.registration.envelope import Envelope
from medial.matching.registration.strongest_paths import strongest_paths

Float = NDArray[np.float64]
Float32 = NDArray[np.float32]
Int = NDArray[np.int64]

INFLUENCES = 4
"""Nodes that move a point, by default. More of them couple limbs that lie side by side."""
SHARED = 0.02
"""Nodes are neighbours if they share more than this part of the mean mass of a node."""
NEAREST = 3
"""Nearest nodes that are neighbours in any case."""
BEND = 0.03
"""Disagreement of neighbours beyond which it costs linearly, in sqrt(area)."""
ELASTIC = 1.25
"""Edges may grow by this factor, around the outside of a joint for instance."""
TORN = 0.25
"""Growth beyond that, relative to the edge, at which an edge is half torn."""
SHORT = 0.04
"""Edges shorter than this, in sqrt(area), count as this long."""
BRIDGE = 0.05
"""Weight of the edges that join nodes which share no points, relative to the mean mass of a node."""


@dataclass(frozen=True)
class Attachment:
    """Which nodes move each of n points.

    Attributes
    ----------
    nodes : (n, influences) int64
    weights : (n, influences) float64
        Rows sum to 1.
    """

    nodes: Int
    weights: Float

    def rows(self, index: Int) -> "Attachment":
        """The attachment of some of the points."""
        return Attachment(self.nodes[index], self.weights[index])

    def smoothed(self, rows: Int, values: Float) -> Float:
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
    envelope : Envelope
        Of the normal equations: nodes that share points or an edge are coupled.
    """

    coordinates: Float32
    rest: Float
    edges: Int
    hold: Float
    reach: float
    envelope: Envelope

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
        ids = eligible[farthest_in_embedding(coordinates[eligible], count, remote)]
        anchors, used = coordinates[ids], np.zeros(1, dtype=bool)
        while not used.all():  # of nodes at one place only some get points
            attachment = attach(coordinates, anchors, influences)
            share = shares(attachment, len(anchors))
            mass = share.sum(axis=0)
            used = mass > 1e-9 * mass.max()
            anchors = anchors[used]
        rest = (share.T @ points) / mass[:, None]
        variance = (share.T @ (points**2).sum(axis=1)) / mass - (rest**2).sum(axis=1)
        reach = float(np.sqrt(np.median(np.maximum(variance, 0))))
        overlap = (share.T @ share).toarray()
        edges, hold = _edges(overlap / mass.mean(), anchors)
        joined = overlap > 0
        joined[edges[:, 0], edges[:, 1]] = joined[edges[:, 1], edges[:, 0]] = True
        order = _along_the_body(joined)
        envelope = Envelope(joined[np.ix_(order, order)].argmax(axis=1))
        rank = np.argsort(order)
        edges = np.sort(rank[edges], axis=1)
        rows = np.lexsort(edges.T[::-1])
        graph = cls(anchors[order], rest[order], edges[rows], hold[rows], reach, envelope)
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
        share = strongest_paths(len(self), self.edges, strength).mean(axis=1)
        return np.asarray(share / share.max())

    def strain(self, pose: Pose) -> float:
        """Weighted mean square disagreement of neighbours, in squared units of length."""
        return float(strain_of_edges(*self._edges_in(pose), BEND))

    def add_edges(self, values: Float, right: Float, pose: Pose, weight: float) -> None:
        """Add the strain times `weight` to the normal equations: the system's values, and (6 N,)."""
        add_edges(values, self.envelope.origin, right, *self._edges_in(pose), weight, BEND)

    def _edges_in(self, pose: Pose) -> tuple[Int, Float, Float, Float, Float, float]:
        return self.edges, self.hold, self.rest, pose.rotations, pose.positions, self.reach


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


def _along_the_body(joined: NDArray[np.bool_]) -> Int:
    """Order of the nodes in which those that are joined, (N, N), have numbers close to each other."""
    return np.asarray(reverse_cuthill_mckee(csr_array(joined), symmetric_mode=True), dtype=np.int64)


def _edges(overlap: Float, anchors: Float32) -> tuple[Int, Float]:
    """Neighbours (nodes that share points, and the nearest ones) and their weights; connected."""
    sharing = np.argwhere(np.triu(overlap, 1) > SHARED)
    nearest = neighbour_pairs(cKDTree(anchors), NEAREST)
    edges = join_parts(np.concatenate([sharing, nearest]), anchors)
    shared = overlap[edges[:, 0], edges[:, 1]]
    hold = np.where(shared > SHARED, shared, BRIDGE)
    return edges, hold / hold.sum()


def moved(
    points: Float, directions: Float, attachment: Attachment, graph: NodeGraph, pose: Pose
) -> tuple[Float, Float]:
    """Points (n, 3) and unit directions (n, 3) that hang on nodes, in a pose."""
    return blend(
        points, directions, attachment.nodes, attachment.weights, graph.rest, pose.rotations, pose.positions
    )


def moved_centers(
    points: Float, centers: Float, attachment: Attachment, graph: NodeGraph, pose: Pose
) -> Float:
    """Medial centres (n, 3) of points (n, 3) that hang on nodes, in a pose; each keeps its distance."""
    spokes = centers - points
    here, toward = moved(points, spokes, attachment, graph, pose)
    return here + np.linalg.norm(spokes, axis=1)[:, None] * toward
