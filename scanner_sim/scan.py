"""The `Scan` type: a point cloud that knows where each point comes from."""

import os
from dataclasses import asdict, dataclass, field, fields, replace
from importlib import import_module
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.points.farthest import farthest_points
from datasets_gen.record_arrays import check_layout, check_values
from datasets_gen.records import InputError, load_record, save_record, unpacking
from datasets_gen.values import check_count, check_seed
from scanner_sim.output.ply import write_points
from scanner_sim.scanner_config import ScannerConfig


@dataclass(frozen=True)
class Scan:
    """Points of one simulated scan with exact ground truth.

    Attributes
    ----------
    points : (n, 3) float64
        Triangulated positions, in the units and the frame of the scanned mesh.
    normals : (n, 3) float64
        Unit, outward.
    face_ids : (n,) int32
        Face of the scanned mesh that the camera ray hit.
    barycentrics : (n, 3) float64
        Where in that face.
    true_points : (n, 3) float64
        The hit itself: residuals are ``points - true_points``.
    intensity : (n,) float64
        Fitted peak; `accept` thresholds it.
    view_ids : (n,) int32
    pixels : (n, 2) int32
        Column and row; of a profiler frame and row.
    width : (n,) float64
        Fitted width s of the peak ``exp(-(theta - angle)^2 / s^2)``, radians of the laser's sweep; of a
        profiler columns.
    angle : (n,) float64
        Fitted position of the peak, radians: 0 along the viewing direction, positive to the right; of a
        profiler the column.
    poses : (V, 4, 4) float64
        Camera-to-mesh matrices (x right, y down, z forward), translation in mesh units; of a profiler in the
        first frame. With two cameras, those of the first come before those of the second.
    scale : float
        Millimetres of the rig per mesh unit.
    shape_name : str
        Name of the scanned shape.
    config : ScannerConfig
    seed : int
    variant : str
        Mitsuba variant that traced the rays; empty for ideal samples.
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    face_ids: NDArray[np.int32]
    barycentrics: NDArray[np.float64]
    true_points: NDArray[np.float64]
    intensity: NDArray[np.float64]
    view_ids: NDArray[np.int32]
    pixels: NDArray[np.int32]
    width: NDArray[np.float64]
    angle: NDArray[np.float64]
    poses: NDArray[np.float64] = field(default_factory=lambda: np.zeros((0, 4, 4)))
    scale: float = 1.0
    shape_name: str = ""
    config: ScannerConfig = field(default_factory=ScannerConfig)
    seed: int = 0
    variant: str = ""

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.points)

    def __repr__(self) -> str:
        """One line: what was scanned, the number of points and of views."""
        return f"Scan({self.shape_name!r}: {len(self):,} points, {len(self.poses)} views)"

    def select(self, index: NDArray[np.integer] | NDArray[np.bool_]) -> "Scan":
        """The points of an index or mask, in its order."""
        picked: dict[str, Any] = {name: getattr(self, name)[index] for name in _ARRAYS}
        return replace(self, **picked)

    def accept(self, peak_threshold: float) -> "Scan":
        """Points whose fitted peak reaches the threshold: a sweep costs one scan.

        Raises
        ------
        InputError
            If the threshold is outside (0, 1], or below that of the scan, which dropped what lies between.
        """
        if not 0 < peak_threshold <= 1:
            raise InputError(f"peak threshold must lie in (0, 1], got {peak_threshold!r}")
        if peak_threshold < self.config.peak_threshold and (self.view_ids >= 0).any():
            raise InputError(
                f"peak threshold {peak_threshold!r} is below the {self.config.peak_threshold!r} that this "
                "scan was made with; scan again with a lower one"
            )
        kept = self.select(self.intensity >= peak_threshold)
        return replace(kept, config=replace(self.config, peak_threshold=peak_threshold))

    def subsample(self, n: int, seed: int = 0) -> "Scan":
        """Farthest-point sample of `n` points; the whole scan if it has no more than that.

        Distances are those of the hits, not of the measured points: a fit that ends otherwise in the last
        digits, as in another Mitsuba variant, then does not lead to another choice of points.

        Parameters
        ----------
        n
            Number of points to keep, at least 1.
        seed
            Picks the first point.
        """
        if check_count(n, "points") >= len(self):
            return self
        start = int(np.random.default_rng(check_seed(seed)).integers(len(self)))
        return self.select(farthest_points(self.true_points, n, start))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write everything as ``.npz``, or the points with their attributes for other programs.

        Properties of a PLY vertex: doubles ``x y z``, barycentrics ``b0 b1 b2``, ``true_x true_y true_z`` and
        the laser's ``angle`` and ``width`` in radians; floats ``nx ny nz intensity``; ints ``view face column
        row``. Open3D (tensor reader) and trimesh keep all of them; MeshLab reads points, normals and
        ``quality``, which repeats the intensity. ``.las``, ``.laz`` and ``.e57`` need the packages of the
        extra ``exports``; see `scanner_sim.output.las` and `scanner_sim.output.e57`.

        Raises
        ------
        InputError
            If the suffix is another one, or the file cannot be written.
        """
        suffix = Path(path).suffix.lower()
        if suffix not in _WRITERS:
            raise InputError(f"cannot write {str(path)!r}; a scan is written as {', '.join(_WRITERS)}")
        module, _, function = _WRITERS[suffix].rpartition(".")
        getattr(import_module(module), function)(path, self)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Scan":
        """Read a ``.npz`` written by `save`."""
        arrays, meta = load_record(path, "Scan")
        with unpacking(path, "Scan"):
            check_layout(arrays, _LAYOUT, finite="points")
            check_values(cls, meta)
            meta["config"] = ScannerConfig.from_dict(meta["config"])
            return cls(**arrays, **meta)


_WHOLE = ("poses", "scale", "shape_name", "config", "seed", "variant")
_ARRAYS = [f.name for f in fields(Scan) if f.name not in _WHOLE]
_LAYOUT = {
    **dict.fromkeys(("points", "normals", "barycentrics", "true_points"), "float n 3"),
    **dict.fromkeys(("intensity", "width", "angle"), "float n"),
    **dict.fromkeys(("face_ids", "view_ids"), "int n"),
    "pixels": "int n 2",
    "poses": "float V 4 4",
}
"""Arrays of a file (`datasets_gen.record_arrays`)."""


_WRITERS = {
    ".npz": "scanner_sim.scan.write_npz",
    ".ply": "scanner_sim.scan.write_ply",
    ".las": "scanner_sim.output.las.write_las",
    ".laz": "scanner_sim.output.las.write_las",
    ".e57": "scanner_sim.output.e57.write_e57",
}
"""Function of a path and a scan by suffix; modules are imported by the first file that needs them."""


def write_npz(path: str | os.PathLike[str], scan: Scan) -> None:
    """Write everything that `Scan.load` reads."""
    arrays = {name: getattr(scan, name) for name in (*_ARRAYS, "poses")}
    meta = {name: getattr(scan, name) for name in ("shape_name", "seed", "scale", "variant")}
    meta["config"] = asdict(scan.config)
    save_record(path, "Scan", arrays, meta)


def write_ply(path: str | os.PathLike[str], scan: Scan) -> None:
    """Write the points with their attributes; the header says what frame and units they are in."""
    notes = import_module("scanner_sim.output.frame_note").frame_note(scan)
    write_points(path, _ply_properties(scan), notes)


def _ply_properties(scan: Scan) -> dict[str, NDArray[Any]]:
    """The attributes of a scan by name of the PLY property."""
    table: list[tuple[str, type, NDArray[Any]]] = [
        ("x y z", np.float64, scan.points),
        ("nx ny nz", np.float32, scan.normals),
        ("intensity", np.float32, scan.intensity),
        ("quality", np.float32, scan.intensity),
        ("view", np.int32, scan.view_ids),
        ("face", np.int32, scan.face_ids),
        ("column row", np.int32, scan.pixels),
        ("b0 b1 b2", np.float64, scan.barycentrics),
        ("true_x true_y true_z", np.float64, scan.true_points),
        ("angle", np.float64, scan.angle),
        ("width", np.float64, scan.width),
    ]
    properties: dict[str, NDArray[Any]] = {}
    for names, kind, values in table:
        columns: NDArray[Any] = np.asarray(values, kind).reshape(len(scan), len(names.split()))
        properties.update(zip(names.split(), columns.T, strict=True))
    return properties
