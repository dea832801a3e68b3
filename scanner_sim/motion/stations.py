"""Where the cameras stand: a pose and a laser for every view and camera."""

import copy
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from datasets_gen.meshes.geometry import winding_number
from datasets_gen.records import InputError
from scanner_sim.optics import viewpoints
from scanner_sim.scanner_config import ScannerConfig
from scanner_sim.tracing.rig_frame import RigFrame
from scanner_sim.tracing.tracer import Tracer

if TYPE_CHECKING:
    from scanner_sim.scan import Scan


def standoff(config: ScannerConfig, frame: RigFrame) -> float:
    """Distance of the eyes from the object's centre, mm; also where the axes of two cameras meet."""
    return config.min_range + frame.diagonal / 2 if config.distance is None else config.distance


def poses(config: ScannerConfig, frame: RigFrame) -> NDArray[np.float64]:
    """Camera-to-rig matrices, mm: of the first camera from every view, then of the second, if there is one.

    Parameters
    ----------
    config
    frame
        Of the object, which stands about the origin of the rig.

    Returns
    -------
    (cameras V, 4, 4) float64
    """
    distance = standoff(config, frame)
    given = viewpoints.matrices(config.views)
    if given is None:
        first = viewpoints.poses(viewpoints.directions(config.views, config.up), distance, config.up)
    else:
        first = given
        first[:, :3, 3] = frame.to_rig(first[:, :3, 3])
    if config.cameras == 1:
        return first
    return np.concatenate([first, viewpoints.second_camera(first, config.baseline, distance)])


def camera_config(config: ScannerConfig, second: bool) -> ScannerConfig:
    """What a camera works with: the second one has its laser on its other side.

    The error of the baseline changes its sign with it; an error of the sheet's angle, which is that of the
    encoder, does not.
    """
    if not second:
        return config
    return replace(config, baseline=-config.baseline, baseline_error=-config.baseline_error)


def tracers(tracer: Tracer) -> list[Tracer]:
    """The tracer of each camera; they share its scenes."""
    found = [tracer]
    if tracer.config.cameras == 2:
        found.append(copy.copy(tracer))
        found[1].config = camera_config(tracer.config, second=True)
    return found


def eyes(scan: "Scan") -> NDArray[np.float64]:
    """Where the camera stood that measured each point of a scan from viewpoints, (n, 3), in the mesh's frame.

    The poses of a profiler are those of the first frame; its cameras then move along the x of the first.
    """
    found = scan.poses[scan.view_ids, :3, 3]
    if scan.config.motion == "profiler":
        stations = len(scan.poses) // scan.config.cameras
        travel = scan.config.profile_step / scan.scale * scan.poses[scan.view_ids % stations, :3, 0]
        found = found + scan.pixels[:, :1] * travel
    return np.asarray(found)


def check_outside(
    places: list[tuple[str, NDArray[np.float64]]], corners: NDArray[np.float64], name: str
) -> None:
    """Raise InputError if a camera or laser stands inside the object.

    Parameters
    ----------
    places
        What stands or moves there, such as ``"laser of view 3"``, and where in the rig, mm, (k, 3).
    corners : (f, 3, 3)
        Of the object's faces, mm.
    name
        Of the object.
    """
    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    for what, track in places:
        within = ((track >= low) & (track <= high)).all(axis=1)  # spares most the sum over all faces
        inside = next((place for place in track[within] if winding_number(corners, place) > 0.5), None)
        if inside is not None:
            raise InputError(
                f"the {what} stands inside {name!r}, {np.linalg.norm(inside):.3g} mm from its centre; "
                f"raise distance or move the poses (the object's largest side: {(high - low).max():.3g} mm)"
            )
