r"""An as-rigid-as-possible deformation of a cloud: an embedded graph of nodes that turn and move.

A node j at g_j carries a rotation R_j and a position y_j. A point x moves with its nearest nodes,

    x' = sum_j w_j(x) (R_j (x - g_j) + y_j),                                              [SSP07]

and neighbouring nodes should move rigidly: an edge (j, k) costs |R_j (g_k - g_j) - (y_k - y_j)|^2 [SA07].
For fixed rotations the positions solve a small linear system; for fixed positions each rotation is a polar
factor. Nodes are neighbours when both their positions and their medial centres are close, so that an arm
does not stick to the torso beside it, while the two sides of a limb move together across missing data.

References
----------
[SSP07] Sumner, Schmid, Pauly: Embedded deformation for shape manipulation. SIGGRAPH 2007.
[SA07] Sorkine, Alexa: As-rigid-as-possible surface modeling. SGP 2007.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import cho_factor, cho_solve
from scipy.spatial import cKDTree

from medial.cloud import Float, Int, farthest_order, neighbour_pairs
from medial.compiled import compiled

INFLUENCES = 5
NEIGHBOURS = 8


@dataclass(frozen=True)
class Pose:
    """Where the nodes are: rotations (K, 3, 3) and positions (K, 3)."""

    rotations: Float
    positions: Float


@dataclass(frozen=True)
class Embedding:
    """How points hang on nodes: the nodes (n, INFLUENCES), their weights, and the points' offsets to them.

    Attributes
    ----------
    nodes : (n, INFLUENCES) int64
    weights : (n, INFLUENCES) float64
        Each row sums to 1.
    offsets : (n, INFLUENCES, 3) float64
    """

    nodes: Int
    weights: Float
    offsets: Float

    def turned(self, rotations: Float) -> Float:
        """The part of x' that depends on the rotations alone, (n, 3)."""
        return _turned(self.nodes, self.weights, self.offsets, rotations)

    def moved(self, pose: Pose) -> Float:
        """Positions of the points in a pose, (n, 3)."""
        return self.turned(pose.rotations) + _blended(self.nodes, self.weights, pose.positions)

    def turned_normals(self, normals: Float, pose: Pose) -> Float:
        """Unit normals of the points in a pose, (n, 3)."""
        same = np.broadcast_to(normals[:, None], self.offsets.shape)
        turned = _turned(self.nodes, self.weights, same, pose.rotations)
        length = np.linalg.norm(turned, axis=1, keepdims=True)
        return turned / np.maximum(length, np.finfo(float).tiny)


class DeformationGraph:
    """Nodes and edges over a cloud, built once per source and used for every candidate map.

    Parameters
    ----------
    points : (n, 3)
    centers : (n, 3)
        Medial centres; for surface operators the points themselves.
    nodes
        Number of nodes, at most n.
    """

    def __init__(self, points: Float, centers: Float, nodes: int) -> None:
        ids = farthest_order(points, nodes)
        self.rest: Float = points[ids]  # (K, 3)
        self.rest_centers: Float = centers[ids]
        self._tree = cKDTree(np.hstack([points, centers])[ids])
        pairs = neighbour_pairs(self._tree, self.rest, NEIGHBOURS)
        self.start: Int = pairs.ravel("F")  # (E,) directed both ways
        self.end: Int = pairs[:, ::-1].ravel("F")
        self.edge: Float = self.rest[self.end] - self.rest[self.start]  # (E, 3)
        self.length2: Float = np.maximum((self.edge**2).sum(axis=1), 1e-12)

    def __len__(self) -> int:
        """Return the number of nodes."""
        return len(self.rest)

    def embed(self, points: Float, centers: Float) -> Embedding:
        """Hang points of the source on their nearest nodes."""
        count = min(INFLUENCES, len(self))
        distance, near = self._tree.query(np.hstack([points, centers]), k=min(count + 1, len(self)))
        distance, near = distance.reshape(len(points), -1), near.reshape(len(points), -1)
        reach = np.maximum(distance[:, -1:], 1e-12)
        weights = (1 - np.minimum(distance[:, :count] / reach, 1)) ** 2 + 1e-9
        weights /= weights.sum(axis=1, keepdims=True)
        nodes = near[:, :count].astype(np.int64)
        return Embedding(nodes, weights, points[:, None] - self.rest[nodes])

    def strain2(self, pose: Pose) -> Float:
        """Squared relative deviation of each edge from a rigid motion, (E,)."""
        turned = np.einsum("eab,eb->ea", pose.rotations[self.start], self.edge)
        stretched = pose.positions[self.end] - pose.positions[self.start]
        return ((stretched - turned) ** 2).sum(axis=1) / self.length2

    def solve_positions(
        self, embedding: Embedding, rotations: Float, targets: Float, weights: Float, stiffness: Float
    ) -> Float:
        """Node positions that bring points to targets while edges stay rigid, for fixed rotations.

        Parameters
        ----------
        embedding
            Of n points.
        rotations : (K, 3, 3)
        targets : (n, 3)
        weights : (n,)
            Of the data.
        stiffness : (E,)
            Of the edges.

        Returns
        -------
        (K, 3) float64
        """
        count = len(self)
        system, right = np.zeros((count, count)), np.zeros((count, 3))
        residual = targets - embedding.turned(rotations)
        _add_points(embedding.nodes, embedding.weights, weights, residual, system, right)
        _add_edges(self.start, self.end, stiffness, rotations, self.edge, system, right)
        system[np.diag_indices(count)] += 1e-9 * np.trace(system) / count
        return cho_solve(cho_factor(system, check_finite=False), right, check_finite=False)

    def fit_rotations(
        self,
        embedding: Embedding,
        positions: Float,
        stiffness: Float,
        normals: Float,
        target_normals: Float,
        weights: Float,
    ) -> Float:
        """Rotations that best turn each node's edges, and its points' normals, into those of the target.

        Parameters
        ----------
        embedding
            Of n points.
        positions : (K, 3)
        stiffness : (E,)
            Of the edges.
        normals, target_normals : (n, 3)
        weights : (n,)
            Of the normals.

        Returns
        -------
        (K, 3, 3) float64
        """
        moments = np.zeros((len(self), 3, 3))
        stretched = positions[self.end] - positions[self.start]
        _add_outer(self.start, stiffness / self.length2, stretched, self.edge, moments)
        for k in range(embedding.nodes.shape[1]):
            pull = weights * embedding.weights[:, k]
            _add_outer(embedding.nodes[:, k], pull, target_normals, normals, moments)
        return polar_rotations(moments + 1e-12 * np.eye(3))


@compiled()
def _turned(nodes: Int, weights: Float, offsets: Float, rotations: Float) -> Float:
    """Sum over a point's nodes of weight times turned offset, (n, 3)."""
    result = np.zeros((len(nodes), 3))
    for n in range(len(nodes)):
        for k in range(nodes.shape[1]):
            turn, w = rotations[nodes[n, k]], weights[n, k]
            for a in range(3):
                for b in range(3):
                    result[n, a] += w * turn[a, b] * offsets[n, k, b]
    return result


@compiled()
def _blended(nodes: Int, weights: Float, values: Float) -> Float:
    """Weighted mean of the values of a point's nodes, (n, 3)."""
    result = np.zeros((len(nodes), 3))
    for n in range(len(nodes)):
        for k in range(nodes.shape[1]):
            for a in range(3):
                result[n, a] += weights[n, k] * values[nodes[n, k], a]
    return result


@compiled()
def _add_points(
    nodes: Int, hang: Float, weights: Float, residual: Float, system: Float, right: Float
) -> None:
    """Normal equations of the data: W^T C W and W^T C r."""
    for n in range(len(nodes)):
        for j in range(nodes.shape[1]):
            row, pull = nodes[n, j], weights[n] * hang[n, j]
            for a in range(3):
                right[row, a] += pull * residual[n, a]
            for k in range(nodes.shape[1]):
                system[row, nodes[n, k]] += pull * hang[n, k]


@compiled()
def _add_edges(
    start: Int, end: Int, stiffness: Float, rotations: Float, edge: Float, system: Float, right: Float
) -> None:
    """Normal equations of the edges."""
    for e in range(len(start)):
        i, j, s = start[e], end[e], stiffness[e]
        system[i, i] += s
        system[j, j] += s
        system[i, j] -= s
        system[j, i] -= s
        for a in range(3):
            wanted = 0.0
            for b in range(3):
                wanted += rotations[i, a, b] * edge[e, b]
            right[j, a] += s * wanted
            right[i, a] -= s * wanted


@compiled()
def _add_outer(nodes: Int, weights: Float, left: Float, right: Float, moments: Float) -> None:
    """Add weight * left right^T of each row to its node's matrix."""
    for n in range(len(nodes)):
        for a in range(3):
            for b in range(3):
                moments[nodes[n], a, b] += weights[n] * left[n, a] * right[n, b]


def polar_rotations(matrices: Float) -> Float:
    """The rotation nearest to each matrix, (K, 3, 3): U diag(1, 1, det) V^T."""
    u, _, vt = np.linalg.svd(matrices)
    sign = np.where(np.linalg.det(u @ vt) < 0, -1.0, 1.0)
    u[:, :, -1] *= sign[:, None]
    return u @ vt


def geman_mcclure(square: Float, scale2: float) -> Float:
    """Weight of a residual in iteratively re-weighted least squares: (s^2 / (s^2 + r^2))^2."""
    return (scale2 / (scale2 + square)) ** 2
