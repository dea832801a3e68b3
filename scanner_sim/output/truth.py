"""The complete surface beside a scan of it: ideal samples, each labelled with whether the scan has it."""

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.records import InputError
from datasets_gen.shape import Shape
from scanner_sim.ideal import sample
from scanner_sim.output.frame_note import frame_note
from scanner_sim.output.ply import write_points
from scanner_sim.scan import Scan

POINTS = 20_000
"""Samples of the surface; their spacing is then well below the radius of coverage."""
SEEN, MISSING = (77, 175, 106), (209, 73, 91)
"""Colours, RGB."""


def write_truth(
    path: str | os.PathLike[str],
    scan: Scan,
    shape: Shape,
    points: int = POINTS,
    radius: float | None = None,
    seed: int = 0,
) -> float:
    """Write ideal samples of the whole surface as PLY, with what a scan has of them.

    Properties of a vertex: doubles ``x y z`` and barycentrics ``b0 b1 b2``; floats ``nx ny nz``, ``distance``
    to the nearest true point of the scan (-1: none) and ``threshold``, the largest peak threshold at which
    the sample is still seen (0: it is missing); ints ``face`` and ``seen`` (1 or 0); colours ``red green
    blue``, green where seen and red where missing.

    Parameters
    ----------
    path
    scan
        Of the shape.
    shape
    points
        Number of samples, at least 1.
    radius
        A sample is seen if a true point of the scan is as near, in mesh units; 1 % of the diagonal of the
        surface's bounding box if not given, as for `coverage`.
    seed
        Of the samples.

    Returns
    -------
    float
        Share of the samples that is missing.

    Raises
    ------
    InputError
        If the radius is not positive, or the file cannot be written.
    """
    radius = 0.01 * shape.diagonal if radius is None else radius
    if not radius > 0:
        raise InputError(f"the radius of what is seen must be positive, got {radius!r}")
    whole = sample(shape, points, seed)
    distance, threshold = survival(whole.points, scan, radius)
    seen = threshold > 0
    colours = np.where(seen[:, None], SEEN, MISSING).astype(np.uint8)
    columns: dict[str, NDArray[Any]] = dict(zip("xyz", whole.points.T, strict=True))
    columns |= dict(zip(("nx", "ny", "nz"), whole.normals.T.astype(np.float32), strict=True))
    columns |= dict(zip(("red", "green", "blue"), colours.T, strict=True))
    columns |= {"seen": seen.astype(np.int32), "face": whole.face_ids.astype(np.int32)}
    columns |= {"distance": distance.astype(np.float32), "threshold": threshold.astype(np.float32)}
    columns |= dict(zip(("b0", "b1", "b2"), whole.barycentrics.T, strict=True))
    note = f"complete truth: seen is 1 within {radius:.6g} units of a true point of the scan"
    write_points(path, columns, (*frame_note(scan), note))
    return float(1 - seen.mean())


def survival(
    places: NDArray[np.float64], scan: Scan, radius: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """How near a scan comes to places on its surface, and up to which peak threshold.

    Parameters
    ----------
    places : (n, 3)
    scan
    radius
        In mesh units.

    Returns
    -------
    distance : (n,) float64
        To the nearest true point; -1 for an empty scan.
    threshold : (n,) float64
        Largest fitted peak among the points within the radius; 0 where there is none.
    """
    if len(scan) == 0:
        return np.full(len(places), -1.0), np.zeros(len(places))
    tree = cKDTree(scan.true_points)
    distance, _ = tree.query(places)
    near = tree.query_ball_point(places, radius)
    count = np.array([len(each) for each in near])
    threshold = np.zeros(len(places))
    found = np.flatnonzero(count)
    if len(found):
        peaks = scan.intensity[np.concatenate([np.asarray(near[k], np.int64) for k in found])]
        starts = np.concatenate([[0], np.cumsum(count[found])[:-1]])
        threshold[found] = np.maximum.reduceat(peaks, starts)
    return np.asarray(distance, np.float64), threshold
