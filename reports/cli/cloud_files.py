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
from datasets_gen.checks import LARGEST
from datasets_gen.meshes.files import check_rows, why_unreadable
from datasets_gen.points.farthest import farthest_points
from datasets_gen.points.strays import stray_points, words

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
    stray : (n,) bool
        Few and far from all others: not matched. The nearest matched point answers for them, without
        confidence.
    """

    points: NDArray[np.float64]
    scan: "Scan"
    kept: NDArray[np.int64]
    nearest: NDArray[np.int64]
    stray: NDArray[np.bool_]

    @classmethod
    def of(cls, scan: "Scan", points: int, seed: int = 0, name: str = "the cloud") -> "ThinnedCloud":
        """Pick at most `points` points by farthest-point sampling, none of them stray.

        The seed picks the first; `name` is for the message.
        """
        stray = stray_points(scan.points)
        if stray.any():
            _log.warning("%s: %s", name, f"{words(stray)}; not matched, the nearest matched point answers")
        body = np.flatnonzero(~stray)
        if len(body) <= points:
            kept = body
        else:
            start = int(np.random.default_rng(seed).integers(len(body)))
            kept = body[farthest_points(scan.points[body], points, start)]
        nearest = cKDTree(scan.points[kept]).query(scan.points)[1]
        return cls(scan.points, scan.select(kept), kept, nearest, stray)

    @classmethod
    def whole(cls, scan: "Scan") -> "ThinnedCloud":
        """All points, as they are."""
        every = np.arange(len(scan))
        return cls(scan.points, scan, every, every, np.zeros(len(scan), dtype=bool))


def read_thinned(path: Path, points: int, seed: int = 0, repair: bool = False) -> ThinnedCloud:
    """Read a cloud and thin it out; see `read_cloud` and `ThinnedCloud.of`."""
    return ThinnedCloud.of(read_cloud(path, points, seed, repair), points, seed, repr(str(path)))


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
    from medial.validation import check_directions, without_direction

    bad = without_direction(scan.normals)
    if not bad.all():
        check_directions(scan.normals, name)
        return scan
    if warn:
        _log.warning("%s has no normals: estimated; give them where the scanner knows them", name)
    if len(scan.poses) and (scan.view_ids >= 0).all():  # then the scanner knows the side
        from scanner_sim.scanner import estimated_normals

        return replace(scan, normals=estimated_normals(scan, "mst"))
    return replace(scan, normals=estimate_normals(scan.points))


def check_finite(scan: "Scan", name: str) -> None:
    """Raise InputError if a cloud is empty or has points that are not finite; `name` is for the message."""
    bad = int((~np.isfinite(scan.points)).any(axis=1).sum())
    if bad:
        first = int((~np.isfinite(scan.points)).any(axis=1).argmax())
        raise InputError(
            f"{name} has {bad} points that are NaN or infinite, the first is number {first}; remove them"
        )
    if len(scan) == 0:
        raise InputError(f"{name} has no points; give at least one")
    if np.abs(scan.points).max() > LARGEST:
        raise InputError(f"{name} has a coordinate of {np.abs(scan.points).max():.3g}; choose larger units")


def file_kind(path: Path) -> str:
    """What an ``.npz`` file of this project holds; anything unreadable is left to the loader to name."""
    try:
        with np.load(path, allow_pickle=False) as data:
            return str(data["kind"])
    except Exception:
        return ""


def _columns(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64] | None]:
    """Points and normals of a text file; commas count as spaces, lines that begin with # are left out."""
    lines = [
        (number, re.split(r"[\s,;]+", line.strip(" \t,;")))
        for number, line in enumerate(_text(path).splitlines(), 1)
        if line.strip() and not line.lstrip().startswith("#")
    ]
    columns = len(lines[0][1]) if lines else 3
    if columns not in (3, 6):
        raise InputError(
            f"{str(path)!r}, line {lines[0][0]}, has {columns} columns; give x y z, or x y z nx ny nz"
        )
    for number, words_of_line in lines:
        if len(words_of_line) != columns:
            raise InputError(
                f"{str(path)!r}, line {number}, has {len(words_of_line)} columns, the first line {columns}; "
                "give as many in each"
            )
    table = np.array([_numbers(row, path, number) for number, row in lines]).reshape(-1, columns)
    return table[:, :3], table[:, 3:] if table.shape[1] == 6 else None


def _text(path: Path) -> str:
    """The text of a file."""
    try:
        return path.read_text(encoding="utf-8")
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be read: {error.strerror}") from error
    except UnicodeDecodeError as error:
        line = path.read_bytes()[: error.start].count(b"\n") + 1
        raise InputError(
            f"{str(path)!r}, line {line}, is no text (byte {error.start}); give x y z [nx ny nz]"
        ) from error


def _numbers(row: list[str], path: Path, line: int) -> list[float]:
    """Words of a line as finite numbers."""
    try:
        numbers = [float(word) for word in row]
    except ValueError as error:
        raise InputError(f"{str(path)!r}, line {line}, is no row of numbers ({error})") from error
    if not np.isfinite(numbers).all():
        raise InputError(f"{str(path)!r}, line {line}, has a number that is NaN or infinite; remove the line")
    return numbers


def _read(path: Path) -> tuple[NDArray[np.float64], NDArray[np.float64] | None, bool]:
    """Points and normals of a ``.ply``, ``.obj`` or ``.off`` file, and whether it has faces."""
    import trimesh

    try:
        found: Any = trimesh.load(path, process=False, skip_materials=True)
        points = np.array(found.vertices, dtype=np.float64)
        normals = None if len(getattr(found, "faces", ())) else _file_normals(path, found, len(points))
        for array in (points, points if normals is None else normals):
            if array.shape != (len(points), 3):
                raise ValueError(f"{len(points)} points with an array of shape {array.shape}")
    except Exception as error:  # parsers raise anything from IndexError to struct.error on a broken file
        why = why_unreadable(path, error)
        raise InputError(f"{str(path)!r} cannot be read ({why}); export it again") from error
    check_rows(path, points)
    return points, normals, len(getattr(found, "faces", ())) > 0


def _file_normals(path: Path, found: Any, n: int) -> NDArray[np.float64] | None:
    """Normals of a cloud, which trimesh leaves in the raw data; None if there are none."""
    if path.suffix.lower() == ".obj":
        lines = [
            _numbers((line.split() + 3 * ["nothing"])[1:4], path, number)
            for number, line in enumerate(path.read_text(errors="replace").splitlines(), 1)
            if line.startswith("vn ")
        ]
        if lines and len(lines) != n:
            _log.warning("%r has %d normals for %d points: not used", str(path), len(lines), n)
        return np.array(lines) if len(lines) == n else None
    raw = found.metadata.get("_ply_raw", {}).get("vertex", {}).get("data")
    try:
        return np.column_stack([np.ravel(raw[name]) for name in ("nx", "ny", "nz")]).astype(np.float64)
    except (TypeError, KeyError, ValueError, IndexError):
        return None
