"""A picture of anything: which figure shows a shape, a cloud, a diffusion or a map."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from matplotlib.figure import Figure

from datasets_gen import Collection, InputError, Shape
from datasets_gen.values import check_count
from medial import Diffusion, Matching
from reports.cli.cloud_files import file_kind
from reports.cli.map_options import map_heading
from reports.figures.cloud_drawing import DrawnCloud
from reports.figures.dense_map import dense_map
from reports.figures.diffusion_modes import diffusion_modes
from reports.figures.scan_series import ScanView, scan_series
from reports.given_clouds import as_cloud, check_pair
from reports.viewer.interactive import InteractiveView
from reports.viewer.views import view_of_map, view_of_scan
from scanner_sim import Scan, sample

SAMPLES = 12_000
"""Points on a mesh that is drawn."""
PER_ROW = 6
"""Poses side by side before a new row begins."""
NAMELESS = "cloud"
"""Title of a cloud of arrays."""
LEAST_VIEW = 520
"""Pixels of a view, whose controls take some."""
HEIGHT = 480
"""Pixels of a cloud."""
LEAST_HEIGHT = 10
RECORDS: dict[str, Callable[[Path], Any]] = {
    "Collection": Collection.load,
    "Correspondence": Matching.load,
    "Diffusion": Diffusion.load,
    "Matching": Matching.load,
    "Scan": Scan.load,
    "Shape": Shape.load,
}
"""How a ``.npz`` file of each kind is read."""


def draw(
    thing: Any,
    *others: Any,
    up: str | None = None,
    height: int = HEIGHT,
    interactive: bool = False,
    **options: Any,
) -> Figure | InteractiveView:
    """Draw anything; see `medialbench.plot`.

    Parameters
    ----------
    thing, *others
        What is drawn; of a `Matching`, its two clouds, or the one that is both.
    up
        Axis that points upwards; that of the scanner for a `Scan`, else "y".
    height
        Pixels of a cloud.
    interactive
        A view that can be turned, of a map or a cloud, instead of a picture.
    **options
        ``mode`` of a `Diffusion`.

    Raises
    ------
    InputError
        If it cannot be drawn, or an option is not known.
    """
    height = check_count(height, "height", LEAST_HEIGHT)
    if isinstance(thing, str | Path):
        thing = _loaded(Path(thing))
    allowed = {"mode"} if isinstance(thing, Diffusion) else set()
    for name in options:
        if name not in allowed:
            raise InputError(f"a picture of a {type(thing).__name__} has no option {name!r}")
    if others and not isinstance(thing, Matching):
        raise InputError(
            f"only a Matching is drawn with clouds; the first argument is {type(thing).__name__!r}"
        )
    axis = _up_axis(up, thing, *others)
    if interactive:
        return _view(thing, others, axis, height)
    if isinstance(thing, Matching):
        return _map(thing, others, height, axis)
    if isinstance(thing, Diffusion):
        return diffusion_modes(thing, height=height, up=axis, **options)
    if isinstance(thing, Collection):
        views = [_mesh(shape) for shape in thing]
        rows = [("", views[i : i + PER_ROW]) for i in range(0, len(views), PER_ROW)]
        return scan_series(rows, axis, height)
    view = _mesh(thing) if isinstance(thing, Shape) else _cloud(thing)
    return scan_series([("", [view])], axis, height, inches=4.0)


def _view(thing: Any, others: tuple[Any, ...], up: int, height: int) -> InteractiveView:
    """A map or a cloud that can be turned."""
    if isinstance(thing, Matching):
        source, target = _clouds_of(thing, others)
        clouds = (source, source) if len(others) == 1 else (source, target)
        scene = view_of_map(clouds, (_caption(source), _caption(target)), thing)
    elif isinstance(thing, Diffusion | Collection):
        raise InputError(
            f"a {type(thing).__name__} has no view that can be turned; leave out interactive=True"
        )
    else:
        cloud = (
            sample(thing, SAMPLES) if isinstance(thing, Shape) else as_cloud(thing, SAMPLES, name=NAMELESS)
        )
        scene = view_of_scan(cloud, cloud.shape_name or NAMELESS)
    return InteractiveView(replace(scene, up=up), max(height, LEAST_VIEW))


def _up_axis(up: str | None, *things: Any) -> int:
    """The axis that is given, or that of the first scan."""
    if up is None:
        up = next((each.config.up for each in things if isinstance(each, Scan)), "y")
    if up not in ("x", "y", "z"):
        raise InputError(f"up must be 'x', 'y' or 'z', got {up!r}")
    return "xyz".index(up)


def _loaded(path: Path) -> Any:
    """What a file holds: a record of this project, or a cloud or mesh."""
    if path.suffix.lower() == ".npz" and path.is_file():
        kind = file_kind(path)
        if kind in RECORDS:
            return RECORDS[kind](path)
    return as_cloud(path, SAMPLES)


def _mesh(shape: Shape) -> ScanView:
    points = sample(shape, SAMPLES)
    size = f"{len(shape.vertices):,} vertices, {len(shape.faces):,} faces"
    return ScanView(points.points, points.normals, shape.name, size)


def _cloud(given: Any) -> ScanView:
    cloud = as_cloud(given, SAMPLES, name=NAMELESS, warn=False)
    return ScanView(cloud.points, cloud.normals, cloud.shape_name or NAMELESS, f"{len(cloud):,} points")


def _caption(cloud: Scan) -> str:
    return f"{len(cloud):,} points" if cloud.shape_name in ("", NAMELESS) else cloud.shape_name


def _clouds_of(found: Matching, others: tuple[Any, ...]) -> tuple[Scan, Scan]:
    """The given clouds of a map, or the points that it holds."""
    if not others:
        if found.source_points is None or found.target_points is None:
            raise InputError("this Matching holds no points; give its clouds, too: plot(matching, a, b)")
        others = (found.source_points, found.target_points)
    if len(others) > 2:
        raise InputError(f"a Matching has two clouds, got {len(others)}; give source and target")
    source, target = (as_cloud(each, SAMPLES, name=NAMELESS, warn=False) for each in (others[0], others[-1]))
    check_pair(found, source, target)
    return source, target


def _map(found: Matching, others: tuple[Any, ...], height: int, up: int) -> Figure:
    source, target = _clouds_of(found, others)
    here, there = (DrawnCloud(c.points, c.normals, _caption(c)) for c in (source, target))
    return dense_map(
        here,
        there,
        found.source_to_target,
        found.confidence,
        found.landmarks,
        height=height,
        up=up,
        heading=map_heading(found),
    )
