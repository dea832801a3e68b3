"""Scans as E57 [E57]: one data set per view, with its pose and the attributes that the format has.

[E57] ASTM E2807-11, "Standard specification for 3D imaging data exchange", 2011.
"""

import os
import uuid
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

from datasets_gen.records import InputError, atomic_path
from scanner_sim.output.frame_note import CAMERA_AXES, frame_note
from scanner_sim.output.packages import check_packages

if TYPE_CHECKING:
    from scanner_sim.scan import Scan


def write_e57(path: str | os.PathLike[str], scan: "Scan") -> None:
    """Write a scan as E57.

    Points of a view are in the coordinates of its camera (x right, y down, z forward), and its pose brings
    them to the mesh; scans without viewpoints have no poses. Attributes: intensity (the fitted peak), row and
    column. The standard's unit is the metre; what is written is the mesh's unit, as the descriptions say.

    Raises
    ------
    InputError
        If a package is missing, the scan is empty, or the file cannot be written.
    """
    check_packages(path)
    from pye57 import libe57

    if len(scan) == 0:
        raise InputError(f"cannot write {str(path)!r}: an .e57 file needs at least one point")
    with atomic_path(path) as temporary:
        file = libe57.ImageFile(str(temporary), "w")
        try:
            file.extensionsAdd("", libe57.E57_V1_0_URI)
            _fill(libe57, file, file.root(), _about(libe57, scan))
            views = libe57.VectorNode(file, True)
            file.root().set("data3D", views)
            file.root().set("images2D", libe57.VectorNode(file, True))
            for view in np.unique(scan.view_ids):
                _add_view(libe57, file, views, scan, int(view))
        finally:
            file.close()


def _about(libe57: Any, scan: "Scan") -> dict[str, Any]:
    """Fields of the file as a whole."""
    return {
        "formatName": "ASTM E57 3D Imaging Data File",
        "guid": f"{{{uuid.uuid4()}}}",
        "versionMajor": libe57.E57_FORMAT_MAJOR,
        "versionMinor": libe57.E57_FORMAT_MINOR,
        "e57LibraryVersion": libe57.E57_LIBRARY_ID,
        "coordinateMetadata": "; ".join(frame_note(scan)[1:]),
    }


def _fill(libe57: Any, file: Any, node: Any, values: Mapping[str, Any]) -> None:
    """Set texts, numbers and tables in a node, as its children by name."""
    for name, value in values.items():
        if isinstance(value, Mapping):
            child = libe57.StructureNode(file)
            _fill(libe57, file, child, value)
        elif isinstance(value, str):
            child = libe57.StringNode(file, value)
        elif isinstance(value, int):
            child = libe57.IntegerNode(file, value)
        else:
            child = libe57.FloatNode(file, value)
        node.set(name, child)


def _add_view(libe57: Any, file: Any, views: Any, scan: "Scan", view: int) -> None:
    """Append the data set of a view and write its points."""
    mine = scan.select(scan.view_ids == view)
    node = libe57.StructureNode(file)
    posed = 0 <= view < len(scan.poses)
    local = mine.points
    note = "; ".join(frame_note(scan))
    if posed:
        turn, place = scan.poses[view, :3, :3], scan.poses[view, :3, 3]
        local = (mine.points - place) @ turn
        note += f"; points are in the camera's coordinates, {CAMERA_AXES}; the pose brings them to the mesh"
    fields = {"guid": f"{{{uuid.uuid4()}}}", "name": f"view {view}", "description": note}
    _fill(libe57, file, node, fields | _limits(mine, local))
    if posed:
        _fill(libe57, file, node, {"pose": _pose(turn, place)})
    columns: dict[str, NDArray[Any]] = {f"cartesian{axis}": local[:, k] for k, axis in enumerate("XYZ")}
    columns |= {"intensity": mine.intensity, "cartesianInvalidState": np.zeros(len(mine), np.uint16)}
    if (mine.pixels >= 0).all():
        columns |= {"columnIndex": mine.pixels[:, 0], "rowIndex": mine.pixels[:, 1]}
    prototype = libe57.StructureNode(file)
    buffers, kept = libe57.VectorSourceDestBuffer(), []
    for name, values in columns.items():
        whole = np.issubdtype(values.dtype, np.integer)
        kept.append(
            np.ascontiguousarray(values, np.uint16 if whole else np.float64)
        )  # buffers do not own them
        prototype.set(name, _prototype(libe57, file, kept[-1]))
        buffers.append(libe57.SourceDestBuffer(file, name, kept[-1], len(mine), True, True))
    points = libe57.CompressedVectorNode(file, prototype, libe57.VectorNode(file, True))
    node.set("points", points)
    views.append(node)
    writer = points.writer(buffers)
    writer.write(len(mine))
    writer.close()


def _prototype(libe57: Any, file: Any, values: NDArray[Any]) -> Any:
    """Type and limits of a column."""
    if values.dtype == np.uint16:
        first, last = int(values.min()), int(values.max())
        return libe57.IntegerNode(file, first, first, last)
    low, high = float(values.min()), float(values.max())
    return libe57.FloatNode(file, low, libe57.E57_DOUBLE, low, high)


def _pose(turn: NDArray[np.float64], place: NDArray[np.float64]) -> dict[str, Any]:
    """Rotation as a unit quaternion, and translation."""
    x, y, z, w = map(float, Rotation.from_matrix(turn).as_quat())
    return {
        "rotation": {"w": w, "x": x, "y": y, "z": z},
        "translation": dict(zip("xyz", map(float, place), strict=True)),
    }


def _limits(scan: "Scan", local: NDArray[np.float64]) -> dict[str, Any]:
    """Bounds that the standard asks for."""
    low, high = local.min(axis=0), local.max(axis=0)
    box = {
        f"{axis}{end}": float(value[k])
        for k, axis in enumerate("xyz")
        for end, value in (("Minimum", low), ("Maximum", high))
    }
    low, high = scan.pixels.min(axis=0), scan.pixels.max(axis=0)
    index = {
        "columnMinimum": int(low[0]),
        "columnMaximum": int(high[0]),
        "rowMinimum": int(low[1]),
        "rowMaximum": int(high[1]),
        "returnMinimum": 0,
        "returnMaximum": 0,
    }
    return {
        "cartesianBounds": box,
        "indexBounds": index,
        "intensityLimits": {"intensityMinimum": 0.0, "intensityMaximum": 1.0},
    }
