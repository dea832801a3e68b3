"""Range images for other programs, as PNG or EXR, with the cameras as JSON."""

import json
import os
from dataclasses import asdict
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from datasets_gen.records import InputError, atomic_path
from scanner_sim.optics.camera import camera_rays
from scanner_sim.optics.triangulation import triangulate
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
    points = triangulate(camera_rays(pixels, scan.config), scan.angle[mine], scan.config.baseline)
    out = np.zeros(scan.config.resolution[::-1])
    out[pixels[:, 1], pixels[:, 0]] = points[:, 2] / scan.scale
    return out


def write_range_images(scan: Scan, folder: str | os.PathLike[str], suffix: str = ".png") -> list[Path]:
    """Write a range image per view, and ``cameras.json`` with all that is needed to use them.

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
        The files, ``cameras.json`` last.

    Raises
    ------
    InputError
        If the suffix is unknown or needs a package that is missing, the scan knows no views, or the folder
        cannot be written.
    """
    if suffix not in (".png", ".exr"):
        raise InputError(f"range images are written as '.png' or '.exr', not {suffix!r}")
    if suffix == ".exr" and find_spec("OpenEXR") is None:
        raise InputError("'.exr' needs a package: pip install OpenEXR, or write '.png'")
    if len(scan.poses) == 0:
        raise InputError("this scan knows no viewpoints, so it has no range images")
    unit = scan.config.max_range / scan.scale / LEVELS
    files, cameras = [], []
    for view, pose in enumerate(scan.poses):
        depth = range_image(scan, view)
        file = Path(folder) / f"view_{view:03d}{suffix}"
        counts = np.clip(np.round(depth / unit), 0, LEVELS).astype(np.uint16)
        _write_image(counts if suffix == ".png" else depth.astype(np.float32), file)
        files.append(file)
        cameras.append({"image": file.name, "camera_to_mesh": pose.tolist()})
    record = {
        "shape": scan.shape_name,
        "intrinsics": intrinsics(scan.config),
        "axes": "camera x right, y down, z forward",
        "depth_unit": unit if suffix == ".png" else 1.0,
        "scanner_mm_per_unit": scan.scale,
        "laser": {"offset": [scan.config.baseline / scan.scale, 0, 0], "axis": [0, 1, 0]},
        "views": cameras,
        "config": asdict(scan.config),
        "seed": scan.seed,
    }
    files.append(Path(folder) / "cameras.json")
    with atomic_path(files[-1]) as temporary:
        temporary.write_text(json.dumps(record, indent=1))
    return files


def _write_image(values: NDArray[Any], file: Path) -> None:
    """Write one channel; Mitsuba's own writer of EXR may wait for its threads for ever."""
    with atomic_path(file) as temporary:
        if file.suffix == ".png":
            Image.fromarray(values).save(temporary, format="PNG")
            return
        import OpenEXR

        header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
        OpenEXR.File(header, {"Y": values}).write(str(temporary))
