"""A cloud of centres, a centre for every point: what both kinds of skeleton are extracted from."""

from dataclasses import dataclass, replace

import networkx as nx
import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.points.neighbours import query_tree
from medial.skeletons.curve_skeleton import CurveSkeleton
from medial.skeletons.graph_cleaning import bridged, collapsed, pruned, without_specks, zipped
from medial.skeletons.line_extraction import joined_groups, sampled
from medial.skeletons.surface_graph import SurfaceGraph
from medial.skeletons.thinning import filled, thinned_centers

Float = NDArray[np.float64]
Int = NDArray[np.int64]

SAME_LIMB = 0.5
"""Centres within this many radii of each other belong to one limb: those of two are a sum of radii apart."""
OTHER_LIMB = 1.0
"""Neighbours on the surface whose centres are farther apart than this many times the sum of their radii are
on two limbs that touch."""
CENTERS_TRIED = 16
"""Nearest centres that may be on one limb with a centre."""
AROUND = 4
"""Surface points around a centre that say whether it is inside."""
SHEET_REACH = 3.0
SHEET = 0.05
"""Second eigenvalue of the normals around a centre up to which it lies in a sheet."""
LEAST_TUBULAR = 0.1
"""Share of the points that have a centre below which a cloud has no skeleton."""
NO_TUBE = (
    "only {share:.0f} % of the points lie on something tubular, where normals turn around an axis; "
    "a flat shape has no curve skeleton"
)
NO_CURVE = (
    "all centres lie within {extent:.2g} of each other, the body around them has a radius of {radius:.2g}; "
    "a ball has no axis, its skeleton is one node"
)


@dataclass(frozen=True)
class SkeletalCloud:
    """Centres of the points of a cloud.

    Attributes
    ----------
    graph : SurfaceGraph
        The points, and which are neighbours.
    centers : (n, 3) float64
    radii : (n,) float64
    known : (n,) bool
        Where there is a centre.
    """

    graph: SurfaceGraph
    centers: Float
    radii: Float
    known: NDArray[np.bool_]

    def inside(self) -> "SkeletalCloud":
        """The same, without centres outside the body: most surface points around those face them."""
        points, normals = self.graph.points, self.graph.normals
        near = query_tree(cKDTree(points), self.centers, k=min(AROUND, len(points)))[1]
        near = near.reshape(len(points), -1)
        outward = np.einsum("nkd,nkd->nk", points[near] - self.centers[:, None], normals[near]) > 0
        return replace(self, known=self.known & (outward.mean(axis=1) > 0.5))

    def without_sheets(self) -> "SkeletalCloud":
        """The same, without centres around which both sides of the surface are flat, as within a sheet.

        Normals of the points within `SHEET_REACH` radii of a centre have a second moment with the eigenvalues
        0, 1/2, 1/2 in a tube, 1/3 in a ball and 0, 0, 1 in a sheet.
        """
        found = self.known.copy()
        ids = np.flatnonzero(self.known)
        tree, normals = cKDTree(self.graph.points), self.graph.normals
        reach = SHEET_REACH * np.maximum(self.radii[ids], self.graph.spacing)
        for i, near in zip(ids, tree.query_ball_point(self.centers[ids], reach), strict=True):
            turn = normals[near].T @ normals[near] / max(len(near), 1)
            found[i] = np.linalg.eigvalsh(turn)[1] > SHEET
        return replace(self, known=found)

    def same_limb(self) -> Int:
        """Pairs of points whose centres are near each other, also across gaps in the surface, (E, 2)."""
        ids = np.flatnonzero(self.known)
        if not len(ids):
            return np.zeros((0, 2), np.int64)
        centers, radii = self.centers[ids], self.radii[ids]
        count = min(CENTERS_TRIED, len(ids))
        gaps, near = query_tree(cKDTree(centers), centers, k=count)
        i, j = np.repeat(np.arange(len(ids)), count), near.ravel()
        close = (gaps.ravel() <= SAME_LIMB * np.minimum(radii[i], radii[j])) & (i != j)
        return np.column_stack([ids[i[close]], ids[j[close]]])

    def joined(self) -> SurfaceGraph:
        """The neighbours on the surface, and those on one limb."""
        pairs = np.sort(np.concatenate([self.graph.pairs, self.same_limb()]), axis=1)
        return replace(self.graph, pairs=np.unique(pairs, axis=0))

    def thinned(self, rounds: int) -> "SkeletalCloud":
        """The same with centres on curves; points without one take part in that of their neighbours."""
        values = np.column_stack([self.centers, self.radii])
        values, known = filled(self.graph.matrix(), values, self.known)
        found = thinned_centers(values[known, :3], values[known, 3], rounds, self.graph.spacing)
        values[known, :3] = found
        return replace(self, centers=values[:, :3], radii=values[:, 3], known=known)


def curve_graph(thin: SkeletalCloud, step: float) -> tuple[nx.Graph, Int]:
    """The graph of a thinned cloud: samples a step apart, joined as the body is, and cleaned.

    Parameters
    ----------
    thin
        Of `SkeletalCloud.thinned`.
    step
        Between samples, in radii of the body.

    Returns
    -------
    graph
        Nodes have a ``place``, a ``radius`` and ``members``, ids among the points with a centre.
    ids : (m,) int64
        The points with a centre.
    """
    ids = np.flatnonzero(thin.known)
    position = np.full(len(thin.known), -1)
    position[ids] = np.arange(len(ids))
    pairs = position[thin.joined().pairs]
    centers, radii = thin.centers[ids], thin.radii[ids]
    pairs = pairs[(pairs >= 0).all(axis=1)]
    apart = np.linalg.norm(centers[pairs[:, 0]] - centers[pairs[:, 1]], axis=1)
    pairs = pairs[apart <= OTHER_LIMB * radii[pairs].sum(axis=1)]
    points, spacing = thin.graph.points[ids], thin.graph.spacing
    graph = joined_groups(sampled(centers, radii, points, pairs, step, spacing), centers, radii, pairs)
    for clean in (collapsed, zipped, collapsed, bridged, zipped, collapsed, pruned, without_specks):
        clean(graph)
    return graph, ids


def as_skeleton(graph: nx.Graph, ids: Int, thin: SkeletalCloud, index: Int, method: str) -> CurveSkeleton:
    """The skeleton of a graph of `curve_graph`.

    Parameters
    ----------
    graph, ids
    thin
    index : (n,) int64
        Place of every point of the given cloud among those of `thin`.
    method
        Of the skeleton.
    """
    number = {node: k for k, node in enumerate(sorted(graph.nodes))}
    owner = np.full(len(thin.known), -1, dtype=np.int64)
    for node, k in number.items():
        owner[ids[graph.nodes[node]["members"]]] = k
    nodes = np.array([graph.nodes[node]["place"] for node in number]).reshape(-1, 3)
    radii = np.array([graph.nodes[node]["radius"] for node in number])
    edges = np.array(sorted(sorted((number[a], number[b])) for a, b in graph.edges), dtype=np.int64)
    found = CurveSkeleton(nodes, edges.reshape(-1, 2), radii, owner[index], method)
    return _single_node(found) if len(nodes) and _is_ball(found) else found


def _is_ball(skeleton: CurveSkeleton) -> bool:
    """Whether all nodes lie within the radius of the body around them."""
    middle = skeleton.nodes.mean(axis=0)
    return bool(2 * np.linalg.norm(skeleton.nodes - middle, axis=1).max() < skeleton.radii.mean())


def _single_node(skeleton: CurveSkeleton) -> CurveSkeleton:
    middle, radius = skeleton.nodes.mean(axis=0), float(skeleton.radii.mean())
    extent = 2 * float(np.linalg.norm(skeleton.nodes - middle, axis=1).max())
    return replace(
        skeleton,
        nodes=middle[None],
        edges=np.zeros((0, 2), np.int64),
        radii=np.array([radius]),
        node_of_point=np.minimum(skeleton.node_of_point, 0),
        reason=NO_CURVE.format(extent=extent, radius=radius),
    )
