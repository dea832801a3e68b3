"""Clouds from files (scans, bare clouds, meshes, which are sampled), and the points of them to match."""

import logging
import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen import MESH_SUFFIXES, InputError, load_mesh
from datasets_gen.points.farthest import farthest_points

if TYPE_CHECKING:
    from scanner_sim import Scan

CLOUD_SUFFIXES = (".npz", *MESH_SUFFIXES, ".xyz")

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ThinnedCloud:
    """A cloud, and the evenly spread part of it that is matched.

    Attributes
    ----------
    points : (n, 3) float64
        As given and in that order; of a mesh, the samples drawn from it.
    scan : Scan
        The m points that are matched. Without ground truth, unless a scan was given: face ids are -1.
    kept : (m,) int64
        Which of `points` they are.
    nearest : (n,) int64
        For each of `points`, the nearest one that is matched.
    """

    points: NDArray[np.float64]
    scan: "Scan"
    kept: NDArray[np.int64]
    nearest: NDArray[np.int64]

    @classmethod
    def of(cls, scan: "Scan", points: int, seed: int = 0) -> "ThinnedCloud":
        """Pick at most `points` points by farthest-point sampling; the seed picks the first."""
        if len(scan) <= points:
            kept = np.arange(len(scan))
        else:
            start = int(np.random.default_rng(seed).integers(len(scan)))
            kept = farthest_points(scan.points, points, start)
        nearest = cKDTree(scan.points[kept]).query(scan.points)[1]
        return cls(scan.points, scan.select(kept), kept, nearest)


def read_thinned(path: Path, points: int, seed: int = 0, repair: bool = False) -> ThinnedCloud:
    """Read a cloud and thin it out; see `read_cloud` and `ThinnedCloud.of`."""
    return ThinnedCloud.of(read_cloud(path, points, seed, repair), points, seed)


def read_cloud(path: Path, points: int, seed: int = 0, repair: bool = False) -> "Scan":
    """Read a cloud, with estimated normals where the file has none.

    Parameters
    ----------
    path
        ``.npz`` (a scan or a shape), ``.ply``, ``.obj``, ``.off`` (a cloud or a mesh) or ``.xyz`` (columns
        x y z or x y z nx ny nz).
    points
        Number of samples to draw from a mesh.
    seed
        Of the samples of a mesh.
    repair
        Of a mesh, see `datasets_gen.load_mesh`.

    Raises
    ------
    InputError
        If the file cannot be used.
    """
    from scanner_sim import sample

    if path.suffix.lower() not in CLOUD_SUFFIXES:
        raise InputError(
            f"{str(path)!r} is no cloud or mesh this project reads; it reads {', '.join(CLOUD_SUFFIXES)}"
        )
    if not path.is_file():
        raise InputError(f"{str(path)!r} {'is a folder' if path.is_dir() else 'does not exist'}; give a file")
    scan = _scan(path)
    if scan is None:
        scan = sample(load_mesh(path, repair=repair), points, seed)
    check_finite(scan, repr(str(path)))
    return with_normals(scan, repr(str(path)))


def _scan(path: Path) -> "Scan | None":
    """The cloud in a file; None for a mesh."""
    from scanner_sim import Scan

    suffix = path.suffix.lower()
    if suffix == ".npz":
        kind = file_kind(path)
        if kind in ("Matching", "Correspondence", "Diffusion", "Collection"):
            raise InputError(f"{str(path)!r} holds a {kind}, no cloud; give a scan, a cloud or a mesh")
        return None if kind == "Shape" else Scan.load(path)
    if suffix == ".xyz":
        return bare_scan(*_columns(path), name=path.stem)
    points, normals, faces = _read(path)
    return None if faces else bare_scan(points, normals, name=path.stem)


def bare_scan(points: NDArray[Any], normals: NDArray[Any] | None, name: str) -> "Scan":
    """A cloud of unknown origin as a `Scan`: face ids, views and pixels are -1; no normals are nan."""
    from scanner_sim import Scan

    n = len(points)
    points = np.asarray(points, np.float64)
    return Scan(
        points=points,
        normals=np.full((n, 3), np.nan) if normals is None else np.asarray(normals, np.float64),
        face_ids=np.full(n, -1, np.int32),
        barycentrics=np.zeros((n, 3)),
        true_points=points,
        intensity=np.ones(n),
        view_ids=np.full(n, -1, np.int32),
        pixels=np.full((n, 2), -1, np.int32),
        width=np.zeros(n),
        angle=np.zeros(n),
        shape_name=name,
    )


def with_normals(scan: "Scan", name: str, warn: bool = True) -> "Scan":
    """The scan, with estimated normals where it has none; `name` is for the warning."""
    from medial.outward import estimate_normals

    if not np.isnan(scan.normals).all():
        return scan
    if warn:
        _log.warning("%s has no normals: estimated; give them where the scanner knows them", name)
    return replace(scan, normals=estimate_normals(scan.points))


def check_finite(scan: "Scan", name: str) -> None:
    """Raise InputError if a cloud is empty or has points that are not finite; `name` is for the message."""
    bad = int((~np.isfinite(scan.points)).any(axis=1).sum())
    if bad:
        raise InputError(f"{name} has {bad} points that are NaN or infinite; remove them")
    if len(scan) == 0:
        raise InputError(f"{name} has no points; give at least one")


def file_kind(path: Path) -> str:
    """What an ``.npz`` file of this project holds; anything unreadable is left to the loader to name."""
    try:
        with np.load(path, allow_pickle=False) as data:
            return str(data["kind"])
    except Exception:
        return ""


def _columns(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Points and normals of a text file; commas count as spaces, lines that begin with # are left out."""
    try:
        text = path.read_text(encoding="utf-8")
        rows = [re.split(r"[\s,;]+", line.strip(" \t,;")) for line in text.splitlines() if line.strip()]
        table = np.array([row for row in rows if not row[0].startswith("#")], dtype=np.float64)
    except (OSError, ValueError) as error:
        raise InputError(f"{str(path)!r} is no table of numbers ({error}); give x y z [nx ny nz]") from error
    if table.ndim != 2 or table.shape[1] not in (3, 6):
        raise InputError(
            f"{str(path)!r} has a table of shape {table.shape}; give 3 columns, or 6 with normals"
        )
    return table[:, :3], table[:, 3:] if table.shape[1] == 6 else None


def _read(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64] | None, bool]:
    """Points and normals of a ``.ply``, ``.obj`` or ``.off`` file, and whether it has faces."""
    import trimesh

    try:
        found: Any = trimesh.load(path, process=False, skip_materials=True)
        points = np.array(found.vertices, dtype=np.float64)
    except Exception as error:  # parsers raise anything from IndexError to struct.error on a broken file
        why = str(error).splitlines()[0] if str(error) else type(error).__name__
        raise InputError(f"{str(path)!r} cannot be read ({why}); export it again") from error
    if len(getattr(found, "faces", ())):
        return points, None, True
    return points, _file_normals(path, found, len(points)), False


def _file_normals(path: Path, found: Any, n: int) -> NDArray[np.float64] | None:
    """Normals of a cloud, which trimesh leaves in the raw data; None if there are none."""
    if path.suffix.lower() == ".obj":
        lines = [
            line.split()[1:4]
            for line in path.read_text(errors="replace").splitlines()
            if line.startswith("vn ")
        ]
        return np.array(lines, dtype=np.float64) if len(lines) == n else None
    raw = found.metadata.get("_ply_raw", {}).get("vertex", {}).get("data")
    try:
        return np.column_stack([np.ravel(raw[name]) for name in ("nx", "ny", "nz")]).astype(np.float64)
    except (TypeError, KeyError, ValueError, IndexError):
        return None
