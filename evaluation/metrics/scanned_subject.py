"""Whether a mesh can be a pose of the subject that was scanned."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.records import InputError
from datasets_gen.shape import Shape
from scanner_sim import Scan

NEIGHBOURS_KEPT = 0.85
"""The least `neighbours_kept` of a scan on a pose of its subject. Of the built-in bodies it is at least .9
with 60 points and .99 with 500; on the mesh of another body at most .9 and .79."""
NEAR = 3.0
"""Neighbours are no farther apart on a pose of the subject than this times what its size asks for."""


def check_subject(scan: Scan, mesh: Shape) -> None:
    """Raise InputError unless a mesh can be a pose of the subject that was scanned (`neighbours_kept`)."""
    kept = neighbours_kept(scan, mesh)
    if kept < NEIGHBOURS_KEPT:
        raise InputError(
            f"the mesh is no pose of the subject of the scan of {scan.shape_name!r}: {kept:.0%} of its "
            "points keep their neighbours there; give a pose of the subject that was scanned"
        )


def neighbours_kept(scan: Scan, mesh: Shape) -> float:
    """Share of a scan's points whose nearest neighbour is as near on a mesh, up to scale and a factor of 2.

    Near 1 on any pose of the subject that was scanned; less where the faces are those of another mesh, and 0
    where most neighbours are far from each other there, as on a ball whose faces are in another order.
    """
    if len(scan) < 2:
        return 1.0
    there = mesh.at(scan.face_ids, scan.barycentrics)
    gap, nearest = (column[:, 1] for column in cKDTree(scan.true_points).query(scan.true_points, k=2))
    apart = gap > 0
    if not apart.any():
        return 1.0
    change = np.linalg.norm(there[nearest] - there, axis=1)[apart] / gap[apart]
    usual = float(np.median(change))
    if usual * _size(scan.true_points) > NEAR * _size(there):
        return 0.0
    return float(((change >= usual / 2) & (change <= 2 * usual)).mean())


def _size(points: NDArray[np.float64]) -> float:
    """Median distance from the centre of points (n, 3)."""
    return float(np.median(np.linalg.norm(points - points.mean(axis=0), axis=1)))
