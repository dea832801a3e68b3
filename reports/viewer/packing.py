"""A scene as text: arrays of few bytes behind a JSON head, deflated, in base64.

Positions take 16 bits a coordinate, normals two bytes (octahedral, [MSS*10]), colours, confidences and fields
one byte a number. Each cloud is drawn in its own unit, the root mean square distance of its points from their
mean, so that bodies have one size whatever the units of their files and whatever is missing here and there.
"""

import base64
import json
import struct
import zlib
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from reports.figures.cloud_drawing import colored_from
from reports.figures.point_renderer import seen_from_behind
from reports.viewer.scene import Scene, ViewCloud, ViewField, ViewMap

STEPS = 65535
FRONT = np.array([(0.0, 0.0, 1.0), (0.0, 0.0, 1.0), (0.0, -1.0, 0.0)])
"""Direction towards the viewer in the front view, by the axis that points up."""
REACH = 0.97
"""Distance of the farthest point of all clouds from the middle of its panel, which is two units wide."""
SAMPLE = 2000
"""Points at which the spacing of a cloud is measured."""


class _Arrays:
    """Arrays one after the other, each at a multiple of 4 bytes, and where they are."""

    def __init__(self) -> None:
        self.parts: list[bytes] = []
        self.size = 0

    def add(self, array: NDArray[Any] | None, kind: str) -> dict[str, Any] | None:
        """Note an array of a kind such as ``u2``."""
        if array is None:
            return None
        data = np.ascontiguousarray(array, dtype=f"<{kind}").tobytes()
        entry = {"kind": kind, "start": self.size, "count": int(np.size(array))}
        data += b"\0" * (-len(data) % 4)
        self.parts.append(data)
        self.size += len(data)
        return entry


def packed(scene: Scene) -> str:
    """The text of a scene, as ``MedialView.decode`` of ``viewer.js`` reads it."""
    arrays, scale = _Arrays(), REACH / max([1e-9, *map(_stretch, scene.clouds)])
    start, turned = _sides(scene)
    filtered = scene.field_of(scene.threshold_on) if scene.threshold_on else None
    head = {
        "title": scene.title,
        "up": scene.up,
        "start": start,
        "errorTop": scene.error_top,
        "clouds": [
            _cloud(each, scale, arrays) | {"behind": behind}
            for each, behind in zip(scene.clouds, turned, strict=True)
        ],
        "maps": [_map(each, scene.clouds[each.target], arrays) for each in scene.maps],
        "truth": arrays.add(scene.truth, "i4"),
        "luts": {name: arrays.add(table, "u1") for name, table in color_tables().items()},
        "filter": filtered
        and {"field": filtered.name, "label": filtered.label, "low": filtered.low, "high": filtered.high},
    }
    return base64.b64encode(zlib.compress(_joined(head, arrays), 9)).decode("ascii")


def _sides(scene: Scene) -> tuple[str, list[bool]]:
    """The view that shows the source from outside, and which clouds it shows from inside."""
    towards = FRONT[scene.up]

    def behind(cloud: ViewCloud) -> bool:
        return cloud.normals is not None and seen_from_behind(cloud.normals, towards)

    start = "front"
    if behind(scene.clouds[0]):
        start, towards = "back", -towards
    return start, [behind(cloud) for cloud in scene.clouds]


def _joined(head: dict[str, Any], arrays: _Arrays) -> bytes:
    """Length of the head, the head, the arrays; places in the head count from the beginning of all."""
    empty = json.dumps(_moved(head, 0))
    room = len(empty.encode()) + 64 + 8 * empty.count('"start"')  # digits that moving may add
    room += -(room + 4) % 4
    text = json.dumps(_moved(head, room + 4)).encode().ljust(room)
    return struct.pack("<I", room) + text + b"".join(arrays.parts)


def _moved(value: Any, by: int) -> Any:
    """The head with all places moved."""
    if isinstance(value, dict):
        if set(value) == {"kind", "start", "count"}:
            return {**value, "start": value["start"] + by}
        return {name: _moved(each, by) for name, each in value.items()}
    return [_moved(each, by) for each in value] if isinstance(value, list) else value


def _cloud(cloud: ViewCloud, scale: float, arrays: _Arrays) -> dict[str, Any]:
    points, centers = _scaled(cloud, scale)
    both = points if centers is None else np.concatenate([points, centers])
    low = both.min(axis=0) if len(both) else np.zeros(3)
    step = max(float((both - low).max(initial=0)) / STEPS, 1e-9)

    def grid(places: NDArray[np.float64] | None) -> NDArray[np.float64] | None:
        return None if places is None else np.round((places - low) / step)

    return {
        "name": cloud.name,
        "caption": cloud.caption,
        "low": low.tolist(),
        "step": step,
        "spacing": _spacing(points),
        "points": arrays.add(grid(points), "u2"),
        "centers": arrays.add(grid(centers), "u2"),
        "normals": None if cloud.normals is None else arrays.add(octahedral(cloud.normals), "i1"),
        "colors": None
        if cloud.colors is None
        else arrays.add(np.round(255 * np.clip(cloud.colors, 0, 1)), "u1"),
        "colorLabel": cloud.color_label,
        "fields": [_field(each, arrays) for each in cloud.fields],
    }


def _unit(points: NDArray[np.float64]) -> float:
    """Root mean square distance of points from their mean."""
    return float(np.sqrt(((points - points.mean(axis=0)) ** 2).sum(axis=1).mean())) or 1.0


def _middle(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Middle of the box of points, (3,)."""
    return (points.min(axis=0) + points.max(axis=0)) / 2


def _stretch(cloud: ViewCloud) -> float:
    """Distance of the farthest point from the middle, in the unit of the cloud."""
    points = np.asarray(cloud.points, dtype=np.float64)
    if not len(points):
        return 0.0
    return float(np.linalg.norm(points - _middle(points), axis=1).max()) / _unit(points)


def _scaled(cloud: ViewCloud, scale: float) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Points and medial centres about the middle of the points, in the unit of the screen."""
    points = np.asarray(cloud.points, dtype=np.float64)
    if not len(points):
        return points, cloud.centers
    middle, factor = _middle(points), scale / _unit(points)
    centers = None
    if cloud.centers is not None:  # a ball that leaves the body says nothing about it
        centers = factor * (np.clip(cloud.centers, points.min(axis=0), points.max(axis=0)) - middle)
    return factor * (points - middle), centers


def _spacing(points: NDArray[np.float64]) -> float:
    """Median distance of a point from its third neighbour: discs of that size close the surface."""
    if len(points) < 4:
        return 0.05
    some = points[:: max(1, len(points) // SAMPLE)]
    return float(np.median(cKDTree(points).query(some, 4)[0][:, 3]))


def octahedral(normals: NDArray[np.float64]) -> NDArray[np.float64]:
    """Unit vectors (n, 3) on the unfolded octahedron, (n, 2) whole numbers in [-127, 127] [MSS*10]."""
    flat = normals / np.maximum(np.abs(normals).sum(axis=1, keepdims=True), 1e-12)
    sign = np.where(flat[:, :2] >= 0, 1.0, -1.0)
    folded = (1 - np.abs(flat[:, 1::-1])) * sign
    return np.round(127 * np.where(flat[:, 2:] < 0, folded, flat[:, :2]))


def _field(given: ViewField, arrays: _Arrays) -> dict[str, Any]:
    span = (given.high - given.low) or 1.0
    shares = np.nan_to_num(np.clip((given.values - given.low) / span, 0, 1))
    return {
        "name": given.name,
        "label": given.label,
        "low": given.low,
        "high": given.high,
        "ends": [f"{given.low:.3g}", f"{given.high:.3g}"],
        "frames": list(given.frames) or None,
        "lut": given.table,
        "values": arrays.add(np.round(255 * shares), "u1"),
    }


def _map(given: ViewMap, target: ViewCloud, arrays: _Arrays) -> dict[str, Any]:
    sure = None if given.confidence is None else np.round(255 * np.clip(given.confidence, 0, 1))
    return {
        "label": given.label,
        "note": given.note,
        "target": given.target,
        "image": arrays.add(given.image, "i4"),
        "fill": arrays.add(colored_from(given.image, target.points), "i4"),
        "confidence": arrays.add(sure, "u1"),
        "errors": None if given.errors is None else arrays.add(np.round(given.errors, 3), "f4"),
        "landmarks": arrays.add(given.landmarks, "i4") if len(given.landmarks) else None,
    }


def color_tables() -> dict[str, NDArray[np.float64]]:
    """The colour tables of the views, each (256, 3) in [0, 255]; those of the figures where they have one."""
    import matplotlib

    from reports.figures.cloud_drawing import ERROR_COLORS
    from reports.figures.dense_map import CONFIDENCE

    steps = np.linspace(0, 1, 256)
    tables = {"viridis": matplotlib.colormaps["viridis"], "error": ERROR_COLORS, "confidence": CONFIDENCE}
    return {name: np.round(255 * table(steps)[:, :3]) for name, table in tables.items()}
