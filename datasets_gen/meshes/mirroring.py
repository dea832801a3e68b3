"""Left and right of a mesh, found from its geometry and its connectivity."""

import warnings

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.meshes.geometry import vertex_normals
from datasets_gen.shape import Shape

SYMMETRIC = 4e-3  # accepted distance of reflected points from the surface, per bounding-box diagonal
ALIKE = 1e-2  # the same for the median, where the connectivity is symmetric as well
REFINEMENTS = 20
TRUSTED = 0.8  # share of the nearest pairs by which a plane is refined
SAMPLES = 2000
SEEDS = 4  # faces from which a symmetry of the connectivity is sought

Plane = tuple[NDArray[np.float64], NDArray[np.float64]]


def mirror_map(shape: Shape, tolerance: float = SYMMETRIC) -> NDArray[np.int64] | None:
    """Find the bilateral symmetry of a shape and the vertex that mirrors each vertex.

    Planes through the centroid across the coordinate and principal axes are refined by alternating between
    nearest points and the best reflection; the plane whose reflection stays closest to the surface wins.
    Each vertex is mapped to the one nearest to its mirror image, unless that is no involution and the
    connectivity is symmetric: then the map follows it, so that a leg put forward does no harm.

    Parameters
    ----------
    shape
        Usually the reference pose.
    tolerance
        Without symmetric connectivity, the largest 95th percentile of the distance between reflected
        vertices and the surface, in bounding-box diagonals.

    Returns
    -------
    (v,) int64 or None
        An involution if the connectivity is symmetric, else up to the spacing of the vertices. None where
        no symmetry is found.
    """
    tree = cKDTree(shape.vertices)
    scale = float(np.linalg.norm(np.ptp(shape.vertices, axis=0)))
    plane, off = _best_plane(shape, tree, scale)
    distance, nearest = tree.query(reflect(shape.vertices, *plane))
    close = bool(np.quantile(off, 0.95) < tolerance * scale)
    if close and np.array_equal(nearest[nearest], np.arange(len(nearest))):
        return nearest.astype(np.int64)
    if np.median(off) < ALIKE * scale:
        exact = _symmetric_connectivity(shape, distance, nearest)
        if exact is not None:
            return exact
    return nearest.astype(np.int64) if close else None


def reflect(
    points: NDArray[np.float64], normal: NDArray[np.float64], origin: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Mirror images of points (n, 3) in the plane through `origin` (3,) across the unit `normal` (3,)."""
    return points - 2 * ((points - origin) @ normal)[:, None] * normal


def best_reflection(points: NDArray[np.float64], images: NDArray[np.float64]) -> Plane:
    """The plane whose reflection takes points (n, 3) closest to images (n, 3), in least squares.

    With u, v the two sets about the mean of all midpoints, |v - u + 2 (u.n) n|^2 differs from |v - u|^2 by
    4 (u.n)(v.n), so n is the lowest eigenvector of the symmetric part of sum u v^T.

    Returns
    -------
    normal (3,), origin (3,)
    """
    origin = (points.mean(axis=0) + images.mean(axis=0)) / 2
    moment = (points - origin).T @ (images - origin)
    return np.linalg.eigh(moment + moment.T)[1][:, 0], origin


def connectivity_mirror(
    faces: NDArray[np.integer], seed: NDArray[np.integer], image: NDArray[np.integer]
) -> NDArray[np.int64] | None:
    """Continue the mirror image of one face over the whole mesh, neighbour by neighbour.

    Parameters
    ----------
    faces : (f, 3)
        Oriented and connected.
    seed : (3,)
        Corners of a face.
    image : (3,)
        Their mirror images, the corners of a face read against its winding.

    Returns
    -------
    (v,) int64 or None
        None where the connectivity is not symmetric in this way; vertices without faces map to themselves.
    """
    apex = {
        (a, b): c for face in faces.tolist() for a, b, c in (face, face[1:] + face[:1], face[2:] + face[:2])
    }
    mirror = dict(zip(seed.tolist(), image.tolist(), strict=True))
    a, b, c = seed.tolist()
    border = [(a, b), (b, c), (c, a)]
    done = set(border)
    while border:
        u, v = border.pop()  # the face on the other side is known by its edge from v to u
        w, opposite = apex.get((v, u)), apex.get((mirror[u], mirror[v]))
        if w is None or opposite is None:
            if w is not opposite:
                return None
            continue
        if mirror.setdefault(w, opposite) != opposite:
            return None
        for edge in ((u, w), (w, v)):
            if edge not in done:
                done.add(edge)
                border.append(edge)
    result = np.arange(int(faces.max()) + 1)
    result[list(mirror)] = list(mirror.values())
    return result if np.array_equal(result[result], np.arange(len(result))) else None


def _best_plane(shape: Shape, tree: cKDTree, scale: float) -> tuple[Plane, NDArray[np.float64]]:
    """The plane of reflection and how far each reflected vertex is from the surface, at most `scale`."""
    points, normals = shape.vertices, vertex_normals(shape.vertices, shape.faces, "area")
    middles = points[shape.faces].mean(axis=1)
    centroid = np.average(middles, axis=0, weights=shape.face_areas)
    with np.errstate(all="ignore"), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        covariance = np.cov((middles - centroid).T, aweights=shape.face_areas)
    if not np.isfinite(covariance).all():  # all area lies in one face
        covariance = np.eye(3)
    sample = points[np.unique(np.linspace(0, len(points) - 1, min(SAMPLES, len(points))).astype(np.int64))]
    best: tuple[Plane, NDArray[np.float64]] | None = None
    for axis in (*np.eye(3), *np.linalg.eigh(covariance)[1].T):
        plane = _refined_plane(sample, tree, axis, centroid)
        image = reflect(points, *plane)
        nearest = tree.query(image)[1]
        off = np.abs(np.einsum("nd,nd->n", image - points[nearest], normals[nearest]))
        agrees = np.einsum("nd,nd->n", reflect(normals, plane[0], np.zeros(3)), normals[nearest]) > 0
        off = np.where(agrees, np.minimum(off, scale), scale)
        if best is None or off.mean() < 0.95 * best[1].mean():  # a tie goes to the earlier axis
            best = plane, off
    assert best is not None
    return best


def _refined_plane(
    points: NDArray[np.float64], tree: cKDTree, normal: NDArray[np.float64], origin: NDArray[np.float64]
) -> Plane:
    for _ in range(REFINEMENTS):
        distance, index = tree.query(reflect(points, normal, origin))
        matched = distance <= np.quantile(distance, TRUSTED)  # one leg before the other must not tilt it
        refined = best_reflection(points[matched], tree.data[index[matched]])
        settled = np.array_equal(refined[0], normal) and np.array_equal(refined[1], origin)
        normal, origin = refined
        if settled:
            break
    return normal, origin


def _symmetric_connectivity(
    shape: Shape, distance: NDArray[np.float64], nearest: NDArray[np.integer]
) -> NDArray[np.int64] | None:
    """The connectivity's own symmetry, started at faces whose mirror images fall onto faces."""
    known = {frozenset(face) for face in shape.faces.tolist()}
    for face in shape.faces[np.argsort(distance[shape.faces].max(axis=1), kind="stable")[:SEEDS]]:
        if frozenset(nearest[face].tolist()) in known:
            mirror = connectivity_mirror(shape.faces, face, nearest[face])
            if mirror is not None:
                everyone = np.arange(len(shape.vertices))
                everyone[: len(mirror)] = mirror
                return everyone
    return None
