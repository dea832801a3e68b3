"""Range images for other programs, as PNG or EXR, with the cameras as JSON."""

import json
import os
from collections.abc import Mapping
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from datasets_gen.extras import pip_install
from datasets_gen.records import InputError, atomic_path
from scanner_sim.motion.stations import camera_config
from scanner_sim.optics.triangulation import triangulated
from scanner_sim.output.frame_note import CAMERA_AXES, frame_note
from scanner_sim.scan import Scan
from scanner_sim.scanner_config import ScannerConfig

LEVELS = 65535
"""Largest value of a 16-bit image."""


def intrinsics(config: ScannerConfig) -> dict[str, Any]:
    """Pinhole parameters of the camera in pixels; a pixel's centre lies at its column and row + 0.5."""
    width, height = config.resolution
    return {
        "width": width,
        "height": height,
        "fx": config.focal,
        "fy": config.focal,
        "cx": width / 2,
        "cy": height / 2,
        "k1": config.distortion[0],
        "k2": config.distortion[1],
    }


def range_image(scan: Scan, view: int) -> NDArray[np.float64]:
    """Measured depth of each pixel of a view in mesh units, before registration; 0 where nothing was.

    Parameters
    ----------
    scan
    view

    Returns
    -------
    (rows, columns) float64
    """
    mine = scan.view_ids == view
    pixels = scan.pixels[mine]
    second = scan.config.cameras == 2 and view >= len(scan.poses) // 2
    points = triangulated(pixels, scan.angle[mine], camera_config(scan.config, second))
    out = np.zeros(scan.config.resolution[::-1])
    out[pixels[:, 1], pixels[:, 0]] = points[:, 2] / scan.scale
    return out


def write_range_images(scan: Scan, folder: str | os.PathLike[str], suffix: str = ".png") -> list[Path]:
    """Write a range image per view, and the cameras.

    ``cameras.json`` has all that is needed to use the images, ``transforms.json`` the same cameras for
    programs of the NeRF family.

    Parameters
    ----------
    scan
    folder
        Made if missing.
    suffix
        ``".png"``: 16 bits, depth = value * ``depth_unit``, 0 where nothing was measured; ``".exr"``: depth
        in mesh units, single precision.

    Returns
    -------
    list of Path
        The files, ``transforms.json`` and ``cameras.json`` last.

    Raises
    ------
    InputError
        If the suffix is unknown or needs a package that is missing, the scan knows no views or is that of a
        line profiler, or the folder cannot be written.
    """
    if suffix not in (".png", ".exr"):
        raise InputError(f"range images are written as '.png' or '.exr', not {suffix!r}")
    if suffix == ".exr" and find_spec("OpenEXR") is None:
        raise InputError(f"'.exr' needs the package OpenEXR: {pip_install('exr')}, or write '.png'")
    if len(scan.poses) == 0:
        raise InputError("this scan knows no viewpoints, so it has no range images")
    if scan.config.motion == "profiler":
        raise InputError("a line profiler has no range images, as its camera moves; save .ply, .las or .e57")
    unit = scan.config.max_range / scan.scale / LEVELS
    files, cameras = [], []
    for view, pose in enumerate(scan.poses):
        depth = range_image(scan, view)
        file = Path(folder) / f"view_{view:03d}{suffix}"
        counts = np.clip(np.round(depth / unit), 0, LEVELS).astype(np.uint16)
        _write_image(counts if suffix == ".png" else depth.astype(np.float32), file)
        files.append(file)
        seen_by = camera_config(scan.config, second=view >= len(scan.poses) // scan.config.cameras)
        laser = {"offset": [seen_by.baseline / scan.scale, 0, 0], "axis": [0, 1, 0]}
        cameras.append({"image": file.name, "camera_to_mesh": pose.tolist(), "laser": laser})
    record = {
        "shape": scan.shape_name,
        "intrinsics": intrinsics(scan.config),
        "axes": f"camera {CAMERA_AXES}",
        "frame": "; ".join(frame_note(scan)[1:]),
        "depth_unit": unit if suffix == ".png" else 1.0,
        "scanner_mm_per_unit": scan.scale,
        "views": cameras,
        "config": asdict(scan.config),
        "seed": scan.seed,
    }
    for name, content in (("transforms.json", transforms(scan, files, record)), ("cameras.json", record)):
        files.append(Path(folder) / name)
        with atomic_path(files[-1]) as temporary:
            temporary.write_text(json.dumps(content, indent=1))
    return files


def transforms(scan: Scan, images: list[Path], record: Mapping[str, Any]) -> dict[str, Any]:
    """The cameras as programs of the NeRF family read them.

    Parameters
    ----------
    scan
    images
        Of its views.
    record
        Of ``cameras.json``: intrinsics, depth unit and frame.

    Returns
    -------
    dict
        ``transform_matrix`` brings camera coordinates of OpenGL (x right, y up, z backward) to the mesh;
        lens parameters are those of COLMAP's and OpenCV's model ``OPENCV``, with pixel centres at halves.
        Depth is along the camera's axis.
    """
    inner = record["intrinsics"]
    lens = {"fl_x": inner["fx"], "fl_y": inner["fy"], "cx": inner["cx"], "cy": inner["cy"]}
    lens |= {"w": inner["width"], "h": inner["height"], "k1": inner["k1"], "k2": inner["k2"]}
    frames = [
        {
            "file_path": image.name,
            "depth_file_path": image.name,
            "transform_matrix": (pose @ np.diag([1.0, -1.0, -1.0, 1.0])).tolist(),
        }
        for image, pose in zip(images, scan.poses, strict=True)
    ]
    return {
        "camera_model": "OPENCV",
        "camera_angle_x": 2 * np.arctan(inner["width"] / 2 / inner["fx"]),
        **lens,
        "p1": 0.0,
        "p2": 0.0,
        "depth_unit_scale_factor": record["depth_unit"],
        "axes": "camera x right, y up, z backward",
        "frame": record["frame"],
        "frames": frames,
    }


def _write_image(values: NDArray[Any], file: Path) -> None:
    """Write one channel; Mitsuba's own writer of EXR may wait for its threads for ever."""
    with atomic_path(file) as temporary:
        if file.suffix == ".png":
            Image.fromarray(values).save(temporary, format="PNG")
            return
        import OpenEXR

        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        OpenEXR.File(header, {"Y": values}).write(str(temporary))
