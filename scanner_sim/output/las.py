"""Scans as LAS or, compressed, LAZ [LAS14], with the attributes that the format lacks as extra bytes.

LAS stores positions as whole steps of 32 bits; the step here is the largest side of the bounding box over
2^31, so that positions are exact to 3e-10 of it.

[LAS14] ASPRS, "LAS specification 1.4, R15", 2019.
"""

import os
from typing import TYPE_CHECKING, Any

import numpy as np

from datasets_gen.records import atomic_path
from scanner_sim.output.frame_note import frame_note
from scanner_sim.output.packages import check_packages

if TYPE_CHECKING:
    from scanner_sim.scan import Scan

STEPS = 2.0**31 - 16
"""Positions along the largest side of the bounding box."""
_TEXT = ("LASF_Spec", 3)
"""User and record of the standard's text area, for descriptions."""


def write_las(path: str | os.PathLike[str], scan: "Scan") -> None:
    """Write a scan as point format 6 of LAS 1.4, compressed if the name ends in ``.laz``.

    Standard fields: x, y, z, intensity (65535 for a peak of 1), point source (view + 1). Extra bytes: normals
    ``nx ny nz`` and ``peak`` (float), ``view face column row`` (int), ``b0 b1 b2 true_x true_y true_z angle
    width`` (double). Frame and units are in the standard's text area.

    Raises
    ------
    InputError
        If a package is missing, or the file cannot be written.
    """
    check_packages(path)
    import laspy

    header = laspy.LasHeader(point_format=6, version="1.4")
    header.generating_software = "medialbench"
    low, high = _bounds(scan)
    header.offsets = (low + high) / 2
    header.scales = np.full(3, max(float((high - low).max()), 1e-9) / STEPS)
    note = "\n".join(frame_note(scan)).encode("ascii")
    header.vlrs.append(laspy.VLR(*_TEXT, description="frame and units", record_data=note + b"\0"))
    columns = _extra(scan)
    header.add_extra_dims(
        [laspy.ExtraBytesParams(name, values.dtype, text) for name, (values, text) in columns.items()]
    )
    las = laspy.LasData(header)
    las.x, las.y, las.z = scan.points.T
    las.intensity = np.round(np.clip(scan.intensity, 0, 1) * 65535).astype(np.uint16)
    las.point_source_id = (scan.view_ids + 1).astype(np.uint16)
    for name, (values, _) in columns.items():
        las[name] = values
    with atomic_path(path) as temporary:
        las.write(str(temporary))


def _bounds(scan: "Scan") -> tuple[Any, Any]:
    """Corners of the bounding box; of nothing, the origin twice."""
    if len(scan) == 0:
        return np.zeros(3), np.zeros(3)
    return scan.points.min(axis=0), scan.points.max(axis=0)


def _extra(scan: "Scan") -> dict[str, tuple[Any, str]]:
    """Extra bytes by name: values and a description of at most 32 characters."""
    table: list[tuple[str, type, Any, str]] = [
        ("nx ny nz", np.float32, scan.normals, "unit normal"),
        ("peak", np.float32, scan.intensity[:, None], "fitted peak of the laser"),
        ("view", np.int32, scan.view_ids[:, None], "viewpoint, from 0"),
        ("face", np.int32, scan.face_ids[:, None], "face of the mesh, from 0"),
        ("column row", np.int32, scan.pixels, "pixel of the camera, from 0"),
        ("b0 b1 b2", np.float64, scan.barycentrics, "barycentric coordinate"),
        ("true_x true_y true_z", np.float64, scan.true_points, "true point, mesh units"),
        ("angle", np.float64, scan.angle[:, None], "radians (profiler: column)"),
        ("width", np.float64, scan.width[:, None], "width of the peak, radians"),
    ]
    out = {}
    for names, kind, values, text in table:
        for name, column in zip(names.split(), np.asarray(values, kind).T, strict=True):
            out[name] = (np.ascontiguousarray(column), text)
    return out
