"""Clouds from files (scans, bare clouds, meshes), and the points of them to match."""

import logging
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen import InputError, Shape
from datasets_gen.checks import scannable
from datasets_gen.clouds.cleaning import check_finite, lacking_normals, with_sound_normals, without_gaps
from datasets_gen.clouds.file_formats import FILE_SUFFIXES, checked_file, read_points
from datasets_gen.clouds.point_cloud import PointCloud, counted
from datasets_gen.clouds.precision import rounding_of
from datasets_gen.meshes.files import as_mesh
from datasets_gen.meshes.geometry import vertex_normals
from datasets_gen.points.farthest import FAR, farthest_points
from datasets_gen.points.strays import stray_points, words

if TYPE_CHECKING:
    from scanner_sim import Scan

CLOUD_SUFFIXES = FILE_SUFFIXES
On = Literal["vertices", "samples"]
"""What of a mesh is matched."""

_log = logging.getLogger(__name__)


@dataclass(frozen=True)
class ThinnedCloud:
    """A cloud, and the evenly spread part of it that is matched.

    Attributes
    ----------
    points : (n, 3) float64
        As given and in that order; of a mesh, its vertices or the samples drawn from it.
    scan : Scan
        The m points that are matched. Without ground truth, unless a scan was given: face ids are -1.
    kept : (m,) int64
        Which of `points` they are.
    nearest : (n,) int64
        For each of `points`, the nearest one that is matched.
    stray : (n,) bool
        Few and far from all others, or vertices of no face: not matched. The nearest matched point answers
        for them, without confidence.
    what : str
        What the points are: ``"points"``, or ``"vertices"`` or ``"samples"`` of a mesh.
    """

    points: NDArray[np.float64]
    scan: "Scan"
    kept: NDArray[np.int64]
    nearest: NDArray[np.int64]
    stray: NDArray[np.bool_]
    what: str = "points"

    @classmethod
    def of(
        cls,
        scan: "Scan",
        points: int,
        seed: int = 0,
        name: str = "the cloud",
        unused: NDArray[np.bool_] | None = None,
        what: str = "points",
    ) -> "ThinnedCloud":
        """Pick at most `points` points by farthest-point sampling, none of them stray.

        The seed picks the first; `name` is for the message. `unused` points, of no surface, count as stray.

        Raises
        ------
        InputError
            If there are too few points to match.
        """
        from medial.validation import check_enough, check_places

        check_enough(len(scan), name)
        away = np.zeros(len(scan), dtype=bool) if unused is None else unused.copy()
        stray = stray_points(scan.points[~away])
        if stray.any():
            _log.warning("%s: %s", name, f"{words(stray)}; not matched, the nearest matched point answers")
        away[np.flatnonzero(~away)[stray]] = True
        body = np.flatnonzero(~away)
        if len(body) <= points:
            kept = body
        else:
            start = int(np.random.default_rng(seed).integers(len(body)))
            kept = body[farthest_points(scan.points[body], points, start)]
        check_places(scan.points[kept], name)
        nearest = cKDTree(scan.points[kept]).query(scan.points)[1]
        return cls(scan.points, scan.select(kept), kept, nearest, away, what)

    @classmethod
    def whole(cls, scan: "Scan") -> "ThinnedCloud":
        """All points, as they are."""
        every = np.arange(len(scan))
        return cls(scan.points, scan, every, every, np.zeros(len(scan), dtype=bool))


def read_thinned(
    path: Path,
    points: int,
    seed: int = 0,
    repair: bool = False,
    on: On = "samples",
    columns: str | None = None,
) -> ThinnedCloud:
    """Read a cloud and thin it out; see `read_cloud` and `ThinnedCloud.of`.

    Parameters
    ----------
    path, points, seed, repair, columns
        As of `read_cloud`.
    on
        What of a mesh is matched: its vertices, all of which are in the result, or samples of its surface.

    Raises
    ------
    InputError
        If the file cannot be used.
    """
    name = repr(str(path))
    content = read_content(path, columns)
    if isinstance(content, Shape) and on == "vertices":
        if repair:
            raise InputError(f"{name}: repair=True drops vertices, --on vertices keeps them all; choose one")
        scan, unused = vertices_of(scannable(content), name)
        return ThinnedCloud.of(scan, points, seed, name, unused, "vertices")
    what = "samples" if isinstance(content, Shape) else "points"
    return ThinnedCloud.of(as_scan(content, path, points, seed, repair), points, seed, name, what=what)


def read_cloud(
    path: Path, points: int, seed: int = 0, repair: bool = False, columns: str | None = None
) -> "Scan":
    """Read a cloud, with estimated normals where the file has none.

    A mesh may have any number of pieces and open boundaries: all of it is sampled, by area.

    Parameters
    ----------
    path
        ``.npz`` (a scan, a shape or plain arrays) or any other of `CLOUD_SUFFIXES`.
    points
        Number of samples to draw from a mesh.
    seed
        Of the samples of a mesh.
    repair
        Of a mesh, go on with its largest component.
    columns
        Names of the columns of a text, see `datasets_gen.clouds.file_formats.read_points`.

    Raises
    ------
    InputError
        If the file cannot be used.
    """
    return as_scan(read_content(path, columns), path, points, seed, repair)


def read_content(path: Path, columns: str | None = None) -> "Scan | Shape | PointCloud":
    """What a file holds, as it is; its remarks go to the log."""
    from scanner_sim import Scan

    file = checked_file(path, CLOUD_SUFFIXES)
    kind = file_kind(file) if file.suffix.lower() == ".npz" else ""
    if kind not in ("", "Scan", "Shape"):
        raise InputError(f"{str(path)!r} holds a {kind}, no cloud; give a scan, a cloud or a mesh")
    if kind:
        return Shape.load(file) if kind == "Shape" else Scan.load(file)
    found = read_points(file, columns)
    if not found.is_mesh:
        found = without_gaps(found, repr(str(path)))
    for remark in found.remarks:
        _log.warning("%s: %s", file.name, remark)
    return as_mesh(found, file) if found.is_mesh else found


def as_scan(
    content: "Scan | Shape | PointCloud", path: Path, points: int, seed: int = 0, repair: bool = False
) -> "Scan":
    """What a file holds as a cloud with normals; a mesh is sampled."""
    from scanner_sim import sample

    if isinstance(content, Shape):
        scan = sample(scannable(content, repair), points, seed)
    elif isinstance(content, PointCloud):
        scan = bare_scan(content.points, content.normals, path.stem)
    else:
        scan = content
    check_finite(scan.points, repr(str(path)))
    return with_normals(scan, repr(str(path)))


def vertices_of(shape: Shape, name: str) -> tuple["Scan", NDArray[np.bool_]]:
    """The vertices of a mesh as a cloud, with normals by the areas of their faces, and which have no face.

    Those without a face keep their place in the order, with the normal of the nearest other vertex.
    """
    used = shape.on_surface
    lost = ~np.isfinite(shape.vertices).all(axis=1)
    if lost.any():
        raise InputError(
            f"{name} has {counted(int(lost.sum()), 'vertex', 'vertices')} of no face that are NaN or "
            "infinite; remove them, or match on samples (--on samples)"
        )
    normals = vertex_normals(shape.vertices, shape.faces, "area")
    body = with_normals(bare_scan(shape.vertices[used], normals[used], shape.name), name)
    normals[used] = body.normals
    if not used.all():
        normals[~used] = body.normals[cKDTree(body.points).query(shape.vertices[~used])[1]]
        _log.warning(
            "%s: %s of no face with area: not matched, the nearest matched one answers",
            name,
            counted(int((~used).sum()), "vertex", "vertices"),
        )
    scan = bare_scan(shape.vertices, normals, shape.name)
    check_finite(scan.points, name)
    return scan, ~used


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
    """The scan, with estimated normals where it has none; `name` is for messages.

    A few that are zero or NaN are estimated from those around them; of many, all
    (`datasets_gen.clouds.cleaning.with_sound_normals`).

    Raises
    ------
    InputError
        If normals have to be estimated, and there is but one point, or single precision has left too little
        of the coordinates.
    """
    sound = with_sound_normals(PointCloud(scan.points, scan.normals))
    rounding, seen = rounding_of(scan.points), len(scan.poses) > 0 and bool((scan.view_ids >= 0).all())
    if sound.normals is None and rounding.hopeless and not seen:
        raise InputError(f"{name} has no normals, and none can be estimated: {rounding.words()}")
    if sound.normals is None and len(scan) == 1:
        raise InputError(f"{name} has 1 point and no normals, and none can be estimated; give more points")
    said = [f"{name}: {line}" for line in (*sound.remarks, rounding.words()) if line]
    if lacking_normals(scan.normals).all():
        said.append(f"{name} has no normals: estimated; give them where the scanner knows them")
    for line in said if warn else []:
        _log.warning("%s", line)
    if sound.normals is not None:
        return scan if sound.normals is scan.normals else replace(scan, normals=sound.normals)
    if seen:  # then the scanner knows the side
        from scanner_sim.scanner import estimated_normals

        return replace(scan, normals=estimated_normals(scan, "mst"))
    from medial.outward import estimate_normals

    return replace(scan, normals=estimate_normals(centred(scan.points)))


def centred(points: NDArray[np.float64]) -> NDArray[np.float64]:
    """Points about their median if they lie far from the origin, over their extent; else as they are."""
    middle = np.median(points, axis=0)
    away = points - middle
    far = np.abs(middle).max() > FAR * np.quantile(np.abs(away), 0.9)
    return np.asarray(away) if far else points


def file_kind(path: Path) -> str:
    """What an ``.npz`` file of this project holds; empty for others, and for what the loader has to name."""
    try:
        with np.load(path, allow_pickle=False) as data:
            ours = "meta" in data and data["kind"].ndim == 0  # a user may call an array so
            return str(data["kind"]) if ours else ""
    except Exception:
        return ""
