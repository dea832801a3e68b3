"""Normals estimated from points alone: PCA, with the sign from the scanner or from a spanning tree.

[Hoppe et al. 1992] "Surface reconstruction from unorganized points", SIGGRAPH.
"""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.sparse.csgraph import breadth_first_order, connected_components, minimum_spanning_tree
from scipy.spatial import cKDTree

from datasets_gen.clouds.point_cloud import counted
from datasets_gen.compiled import compiled
from datasets_gen.points.neighbours import query_tree
from datasets_gen.points.outside import outward_field
from datasets_gen.records import InputError

STIFFNESS = 0.5
"""Votes that it takes to break the tree, a point seen face on having one. Signs are right most often with
this on noisy dumbbells of any density: a stiffer tree turns whole ends, a softer one believes each grazing
point."""
STIFFNESS_OF_FIELD = 20.0
"""The same where the cloud's own field votes: it errs over whole hollows, the tree at single edges."""


def pca(points: NDArray[np.float64], neighbours: int = 12) -> NDArray[np.float64]:
    """Unit normals by principal components of each point and its nearest neighbours; signs are arbitrary.

    Parameters
    ----------
    points : (n, 3)
    neighbours
        Number of neighbours, the point itself not counted.

    Returns
    -------
    (n, 3) float64

    Raises
    ------
    InputError
        If there are not more points than neighbours.
    """
    index = _nearest(points, neighbours)
    out = np.empty_like(points)
    for part in np.array_split(np.arange(len(points)), max(1, len(points) // 100_000)):
        cloud = points[index[part]]  # (m, k, 3)
        cloud = cloud - cloud.mean(axis=1, keepdims=True)
        out[part] = np.linalg.eigh(np.einsum("mki,mkj->mij", cloud, cloud))[1][:, :, 0]
    return out


def pca_by_view(
    points: NDArray[np.float64], view_ids: NDArray[np.integer], neighbours: int = 12
) -> NDArray[np.float64]:
    """As `pca`, with neighbours of the same view alone: other views are nearer but not better aligned.

    Parameters
    ----------
    points : (n, 3)
    view_ids : (n,)
        Views with too few points take neighbours from all.
    neighbours
        Number of neighbours, the point itself not counted.

    Returns
    -------
    (n, 3) float64

    Raises
    ------
    InputError
        If a view has too few points and so have all together.
    """
    out = np.empty_like(points)
    views, counts = np.unique(view_ids, return_counts=True)
    if (counts <= neighbours).any():
        out = pca(points, neighbours)
    for view in views[counts > neighbours]:
        mine = view_ids == view
        out[mine] = pca(points[mine], neighbours)
    return out


def _nearest(points: NDArray[np.float64], neighbours: int) -> NDArray[np.int64]:
    """Each point and its nearest neighbours, (n, neighbours + 1)."""
    if len(points) <= neighbours:
        raise InputError(
            f"{counted(len(points), 'point')}: too few for normals from "
            f"{counted(neighbours, 'neighbour')} each"
        )
    return query_tree(cKDTree(points), points, k=neighbours + 1)[1]


def toward(
    normals: NDArray[np.float64], points: NDArray[np.float64], eyes: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Normals turned to the side from which each point was seen.

    Parameters
    ----------
    normals, points, eyes : (n, 3)
        The eye is where the camera stood for that point.

    Returns
    -------
    (n, 3) float64
    """
    facing = np.einsum("nd,nd->n", normals, eyes - points)
    return np.where(facing[:, None] < 0, -normals, normals)


def spanning_tree(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    neighbours: int = 12,
    eyes: NDArray[np.float64] | None = None,
) -> NDArray[np.float64]:
    """Normals with signs made consistent along a minimum spanning tree [Hoppe et al. 1992].

    Neighbours whose tangent planes are closest to parallel pass the sign on. The points vote for the side
    from which they were seen, and the tree breaks where the votes beyond are against the sign that is passed
    on: of all signs s, those with the largest
    sum of s n . (direction to the eye) - `STIFFNESS` * (broken edges) are taken. Without eyes they vote for
    the side to which the rest of the cloud pushes them (`outside.outward_field`); each connected piece of the
    neighbour graph is then decided by all others, too.

    Parameters
    ----------
    points, normals : (n, 3)
    neighbours
        Of each point in the graph, the point itself not counted.
    eyes : (n, 3), optional
        Where the camera stood for each point.

    Returns
    -------
    (n, 3) float64

    Raises
    ------
    InputError
        If there are not more points than neighbours.
    """
    n = len(points)
    columns = _nearest(points, neighbours)[:, 1:].ravel().astype(np.int32)  # as SciPy wants them
    rows = np.repeat(np.arange(n, dtype=np.int32), neighbours)
    agreement = np.abs(np.einsum("ij,ij->i", normals[rows], normals[columns]))
    weights = 1.0 + 1e-6 - agreement  # explicit zeros would be no edges
    graph = csr_array((weights, (rows, columns)), shape=(n, n))
    tree = minimum_spanning_tree(graph.maximum(graph.T))
    pieces, labels = connected_components(tree, directed=False)
    oriented = normals.copy()
    if eyes is None:
        sight, stiffness = outward_field(points), STIFFNESS_OF_FIELD
    else:
        sight, stiffness = eyes - points, STIFFNESS
        sight /= np.linalg.norm(sight, axis=1, keepdims=True)
    place = np.empty(n, np.int64)
    for piece in range(pieces):
        members = np.flatnonzero(labels == piece)
        order, parents = breadth_first_order(tree, members[0], directed=False)
        _pass_on(order, parents, oriented)
        votes = np.einsum("ij,ij->i", oriented[order], sight[order])
        place[order] = np.arange(len(order))
        oriented[order] *= _elected(place[parents[order[1:]]], votes, stiffness)[:, None]
    return oriented


@compiled()
def _pass_on(order: NDArray[np.int32], parents: NDArray[np.int32], normals: NDArray[np.float64]) -> None:
    """Turn each normal to the side of its parent's, in breadth-first order."""
    for i in order[1:]:
        p = parents[i]
        dot = 0.0
        for d in range(3):
            dot += normals[i, d] * normals[p, d]
        if dot < 0:
            for d in range(3):
                normals[i, d] = -normals[i, d]


@compiled()
def _elected(parents: NDArray[np.int64], votes: NDArray[np.float64], stiffness: float) -> NDArray[np.float64]:
    """Signs (m,) on a tree that maximise ``votes @ signs / 2 - stiffness * (edges between unlike signs)``.

    Dynamic programming over a tree whose nodes are in breadth-first order; `parents` (m - 1,) are those of
    nodes 1, 2, ..., `votes` (m,).
    """
    count = len(votes)
    gain = np.empty((count, 2))  # of the best signs below a node if the node's own is 1 or -1
    gain[:, 0], gain[:, 1] = votes / 2, -votes / 2
    for i in range(count - 1, 0, -1):
        p = parents[i - 1]
        gain[p, 0] += max(gain[i, 0], gain[i, 1] - stiffness)
        gain[p, 1] += max(gain[i, 1], gain[i, 0] - stiffness)
    signs = np.ones(count)
    if gain[0, 1] > gain[0, 0]:
        signs[0] = -1.0
    for i in range(1, count):
        own = 0 if signs[parents[i - 1]] > 0 else 1
        breaks = gain[i, 1 - own] - stiffness > gain[i, own]
        signs[i] = -signs[parents[i - 1]] if breaks else signs[parents[i - 1]]
    return signs
