r"""Medial centres and radii (Eq. 9), dual areas (Eq. 10 and the hulls after it): the fast form."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array
from scipy.spatial import cKDTree

from datasets_gen.compiled import compiled, ranges, run_tasks
from datasets_gen.points.neighbours import query_tree
from medial.areas.hull_triangles import hull_areas
from medial.areas.surface_cells import surface_areas
from medial.similarity.candidate_ball import candidate_ball, columns
from medial.similarity.leaves import kd_order, leaf_spheres
from medial.validation import OrientedCloud, check_cloud, check_points

EPSILON = 1.5  # radius of Eq. 10 in units of the average sampling distance
JOINED = 12  # points nearest to each one that join its hull (`dual_areas`)
ROWS_PER_TASK = 512
LEAVES_PER_TASK = 64


def medial_axis(
    points: NDArray[np.floating], normals: NDArray[np.floating], phi: csr_array
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Medial axis point and radius of every point: averages of its candidate balls weighted by phi (Eq. 9).

    Parameters
    ----------
    points, normals : (n, 3)
        The cloud and its outward unit normals.
    phi : (n, n) csr_array
        From `medial.similarity`.

    Returns
    -------
    centers : (n, 3) float64
    radii : (n,) float64
        A point without any similar point takes the radius of the nearest point that has one, and the centre
        at that depth below itself; in a cloud without any similarity the centre is the point, the radius 0.
    """
    return medial_balls(check_cloud(points, normals), phi)


def medial_balls(cloud: OrientedCloud, phi: csr_array) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """`medial_axis` of a cloud that has been checked."""
    points, normals, phi = cloud.points, cloud.normals, csr_array(phi)
    arrays = (
        *columns(points),
        *columns(normals),
        phi.indptr.astype(np.int64),
        phi.indices.astype(np.int64),
        phi.data,
    )
    parts = run_tasks(_averages, [(*arrays, *span) for span in ranges(len(points), ROWS_PER_TASK)])
    centers = np.concatenate([part[0] for part in parts])
    radii = np.concatenate([part[1] for part in parts])
    known = radii > 0
    if known.any() and not known.all():
        _, nearest = cKDTree(points[known]).query(points[~known])
        radii[~known] = radii[known][nearest]
    lost = ~known
    centers[lost] = points[lost] - radii[lost, None] * normals[lost]
    return centers, radii


@compiled()
def _averages(px, py, pz, nx, ny, nz, indptr, indices, data, start, stop):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    centers = np.zeros((stop - start, 3))
    radii = np.zeros(stop - start)
    for i in range(start, stop):
        total = x = y = z = radius = 0.0
        for entry in range(indptr[i], indptr[i + 1]):
            j = indices[entry]
            cx, cy, cz, r, _ = candidate_ball(px, py, pz, nx, ny, nz, i, j)
            if r > 0.0:
                weight = data[entry]
                total += weight
                x += weight * cx
                y += weight * cy
                z += weight * cz
                radius += weight * r
        if total > 0.0:
            centers[i - start, 0] = x / total
            centers[i - start, 1] = y / total
            centers[i - start, 2] = z / total
            radii[i - start] = radius / total
    return centers, radii


def dual_areas(
    points: NDArray[np.floating],
    centers: NDArray[np.floating],
    radii: NDArray[np.floating],
    normals: NDArray[np.floating] | None = None,
    nearest: int = 0,
) -> NDArray[np.float64]:
    r"""Dual area |\star p| of every point: a third of the hull triangles around it (Eq. 10).

    The hull is that of the points with medial centres within 1.5 sampling distances of this point's; where
    the point is not on that hull, all points are projected to its ball (centre, radius) first. Points with
    fewer than four such neighbours, or in one plane with them, take the area of their cell in the tangent
    plane.

    Parameters
    ----------
    points : (n, 3)
    centers : (n, 3)
    radii : (n,)
        From `medial_axis`.
    normals : (n, 3), optional
        For the fallback; the direction from the centre to the point where not given.
    nearest
        Points next to this one that join the hull in any case. Eq. 10 has none: then a point whose neighbours
        on the surface happen to have other medial centres gets triangles that span half the body (on a human
        at 20,000 points, a third of the total area sits on 4 % of the points).

    Returns
    -------
    (n,) float64, in squared units
    """
    points = check_points(points)
    medial: NDArray[np.float64] = np.ascontiguousarray(centers, dtype=np.float64)
    depths: NDArray[np.float64] = np.ascontiguousarray(radii, dtype=np.float64)
    areas = areas_of_hulls(points, cKDTree(points), medial, depths, nearest)
    if np.isnan(areas).any():
        outward = points - centers if normals is None else np.asarray(normals, dtype=np.float64)
        areas = np.where(np.isnan(areas), surface_areas(points, outward), areas)
    return areas


def areas_of_hulls(
    points: NDArray[np.float64],
    tree: cKDTree,
    centers: NDArray[np.float64],
    radii: NDArray[np.float64],
    nearest: int = 0,
) -> NDArray[np.float64]:
    """`dual_areas` of points that have been checked; NaN where a point has no hull."""
    order = kd_order(centers)
    sphere = leaf_spheres(centers[order])
    distances, neighbours = query_tree(tree, points[order], k=max(nearest, 1) + 1)
    epsilon = EPSILON * float(distances[:, 1].mean())
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    joined = np.ascontiguousarray(place[neighbours[:, 1 : nearest + 1]])
    arrays = (points[order], centers[order], radii[order], joined, sphere, epsilon)
    parts = run_tasks(hull_areas, [(*arrays, *span) for span in ranges(len(sphere), LEAVES_PER_TASK)])
    areas = np.empty(len(points))
    areas[order] = np.concatenate(parts)
    return np.where(areas > 0, areas, np.nan)


def calibrated(areas: NDArray[np.float64], surface: NDArray[np.float64]) -> NDArray[np.float64]:
    """Dual areas scaled so that their median ratio to the surface areas is 1.

    Around most points nothing is missing, and there both measure the same thing. The hulls of Eq. 10 fall
    short by a share that depends on the sampling (9 % at 5,000 points on a human, 3 % at 20,000).

    Parameters
    ----------
    areas, surface : (n,)
        From `dual_areas` and `medial.surface_areas`.
    """
    return areas / float(np.median(areas / surface))
