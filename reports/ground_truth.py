"""The ground truth of a scan on the rest pose of its body: for errors in one call."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen import Collection, InputError, Shape
from datasets_gen.correspondences.point_map import PointMap
from datasets_gen.meshes.geometry import face_normals
from evaluation.metrics.correspondence import SurfacePoints, correspondence_error
from evaluation.metrics.diffusion_error import diffusion_error
from evaluation.metrics.geodesic import SurfaceDistance
from evaluation.metrics.map_score import MapScore, score_scans
from evaluation.metrics.scanned_subject import check_subject
from medial import Diffusion, Matching
from reports.given_clouds import check_pair
from scanner_sim import Scan, sample

ON_SURFACE = 1e-3
"""Largest median change, in sqrt(area), of distances between a scan's exact hits, on the pose they are of."""


def rest_pose(body: Collection | Shape) -> Shape:
    """The shape on which errors are measured.

    Raises
    ------
    InputError
        If it is neither a collection nor a shape.
    """
    if isinstance(body, Collection):
        return body.reference
    if isinstance(body, Shape):
        return body
    raise InputError(f"{type(body).__name__!r} is no body; give a Collection or the Shape of the rest pose")


def places_on(body: Collection | Shape, scan: Scan, name: str) -> SurfacePoints:
    """Where the points of a scan lie on the rest pose.

    Parameters
    ----------
    body, scan
    name
        For messages.

    Raises
    ------
    InputError
        If the scan does not know where its points come from, or they come from another body.
    """
    rest = rest_pose(body)
    if not isinstance(scan, Scan):
        raise InputError(f"the {name} is {type(scan).__name__!r}, which has no ground truth; give a Scan")
    if (scan.face_ids < 0).any():
        raise InputError(
            f"the {name} has no ground truth (face ids of -1); give a scan made by scan() or sample()"
        )
    poses = (rest, *body) if isinstance(body, Collection) else (rest,)
    places = SurfacePoints(scan.face_ids, scan.barycentrics)
    scanned = next((pose for pose in poses if pose.name == scan.shape_name), None)
    if scanned is not None:
        if not _hit(scanned, places, scan):
            raise InputError(
                f"the {name} is a scan of {scan.shape_name!r}, but not of the one given: its points lie "
                "elsewhere on these faces; give the body that was scanned, with its faces in their order"
            )
        if isinstance(body, Collection):
            places = SurfacePoints(*body.on_reference(scanned, scan.face_ids, scan.barycentrics))
        return places
    if len(scan) and scan.face_ids.max() >= len(rest.faces):
        raise InputError(
            f"the {name} has points on face {scan.face_ids.max()}, but {rest.name!r} has {len(rest.faces)} "
            "faces; give the body that was scanned"
        )
    subject = scan.shape_name.rpartition("/")[0]
    untold = not subject and isinstance(body, Shape)  # a scan of a file, and one pose: any other may be meant
    if subject != body.subject and not untold and not any(_hit(pose, places, scan) for pose in poses):
        raise InputError(
            f"the {name} is a scan of {scan.shape_name!r}, which is no pose of {body.subject!r}; "
            "give the body that was scanned"
        )
    check_subject(scan, rest)
    return places


def _hit(pose: Shape, places: SurfacePoints, scan: Scan) -> bool:
    """Whether a scan was made of a pose, turned, moved and scaled or not.

    Its exact hits are then as far from each other as where the pose has their faces.
    """
    if len(scan) < 2:
        return True
    if scan.face_ids.max() >= len(pose.faces):
        return False
    there, here = (np.linalg.norm(np.diff(p, axis=0), axis=1) for p in (places.on(pose), scan.true_points))
    scale = float(np.median(here)) / max(float(np.median(there)), np.finfo(float).tiny)
    return bool(np.median(np.abs(here - scale * there)) <= ON_SURFACE * scale * np.sqrt(pose.area))


def geodesic_error_of_map(
    matching: Matching, source: Scan, target: Scan, body: Collection | Shape
) -> NDArray[np.float64]:
    """Errors of a map per source point, x 100 / sqrt(area); see `medialbench.geodesic_error`."""
    rest = rest_pose(body)
    here, there = places_on(body, source, "source"), places_on(body, target, "target")
    check_pair(matching, source, target)
    distance = SurfaceDistance(rest)
    return 100 * correspondence_error(distance, here, there, matching.source_to_target, rest.area)


def score(matching: Matching, source: Scan, target: Scan, body: Collection | Shape) -> MapScore:
    """Say how right a map between two scans is, and how right it could be.

    Parameters
    ----------
    matching, source, target, body
        As for `medialbench.geodesic_error`. Only a `Collection` knows which limbs mirror each other.

    Returns
    -------
    MapScore
        ``summary()`` has the numbers by name: mean error, the least one that these scans allow, shares of
        points below some errors, and of limbs on the right limb and on its mirror image.

    Raises
    ------
    InputError
        If a scan has no ground truth or is of another body, or the map is not between these scans.
    """
    here, there = places_on(body, source, "source"), places_on(body, target, "target")
    check_pair(matching, source, target)
    source, target = _placed(source, here), _placed(target, there)
    found = PointMap(matching.source_to_target, confidence=matching.confidence)
    mirror = body.mirror if isinstance(body, Collection) else None
    return score_scans(found, source, target, rest_pose(body), mirror=mirror)


def _placed(scan: Scan, places: SurfacePoints) -> Scan:
    """The scan with faces of the rest pose, where its pose has a mesh of its own."""
    return replace(scan, face_ids=np.asarray(places.face_ids, np.int32), barycentrics=places.barycentrics)


def diffusion_error_of_scan(
    scan: Scan, body: Collection | Shape, operator: str, modes: int, seed: int, settings: Mapping[str, Any]
) -> float:
    """Eq. 18 of a scan against as many samples of the rest pose; see `medialbench.diffusion_error`."""
    rest = rest_pose(body)
    places = places_on(body, scan, "scan")
    complete = sample(rest, len(scan), seed)
    reference, cloud = (
        Diffusion.from_points(each.points, each.normals, operator=operator, modes=modes, **settings)
        for each in (complete, scan)
    )
    normals = face_normals(rest.vertices, rest.faces)[places.face_ids]
    return diffusion_error(reference, cloud, places.on(rest), normals, rest.area, seed=seed).eq18
