"""``medialbench match``: the correspondence of two clouds in files."""

from collections.abc import Mapping
from math import isnan
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from reports.cli.console import Failure, say
from reports.cli.map_alternatives import said_of_alternatives, write_alternatives
from reports.cli.map_options import (
    check_map_outputs,
    draw_map,
    map_options,
    matched_on,
    matcher_settings,
    operators_of,
    said_of_kinds,
    show_map,
    summary,
    write_map,
)
from reports.cli.progress import steps
from reports.cli.set_options import CommandWithSettings, parsed

if TYPE_CHECKING:
    from reports.cli.setting_list import Setting

METHOD = "medial"

STEPS = (
    ("reading", 1),
    ("loading libraries", 2),
    ("operators of both clouds", 8),
    ("matching", 16),
    ("writing", 1),
)


def listed(given: Mapping[str, Any]) -> list["Setting"]:
    """What ``--set`` takes: options of the method, and settings of the matcher where it is one of ours."""
    from evaluation.methods.catalogue import find
    from evaluation.methods.spectral import Spectral
    from reports.cli.setting_list import settings_of

    method = find(given.get("method") or METHOD)
    own = settings_of(method, ("settings",))
    return own + matcher_settings() if issubclass(method, Spectral) else own


@click.command(
    cls=CommandWithSettings,
    listed=listed,
    about="An option of the method, as config=paper (the settings of Sec. 4) or finalists=4",
    short_help="Match two clouds point by point.",
)
@click.argument("source", type=click.Path(path_type=Path))
@click.argument("target", type=click.Path(path_type=Path))
@map_options
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), help="Map to write.  [default: SOURCE-TARGET.map.npz]"
)
@click.option(
    "--method",
    default=METHOD,
    show_default=True,
    help="Matching method; see medialbench doctor. medial, heat and robust are operator= in Python.",
)
@click.option(
    "--alternatives",
    is_flag=True,
    help="Also write (and draw) each other map that may be right instead, as OUT-2, OUT-3 ....",
)
def match(
    source: Path,
    target: Path,
    out: Path | None,
    points: int,
    modes: int,
    device: str,
    departures: Any,
    seed: int,
    repair: bool,
    on: Any,
    columns: str | None,
    picture: Path | None,
    view: Path | None,
    method: str,
    settings: tuple[str, ...],
    alternatives: bool,
    quiet: bool,
) -> None:
    """Match two clouds: for every point of SOURCE, a point of TARGET.

    Both are scans, clouds or meshes of any program of the field: .npz, .ply, .obj, .off, .stl, .glb, .xyz,
    .txt, .pts, .csv, .pcd, .npy or .las; medialbench inspect shows what is in one. Missing normals are
    estimated. Meshes may be open and in pieces. The map holds source_to_target (for each of source_points an
    index into target_points), confidence in [0, 1] and landmarks (pairs of such indices); an -o that ends in
    .txt, .csv, .map, .vts or .mat holds the indices in that format, one for each vertex of a mesh. Where the
    clouds leave open which map is right, as front for back, the probability of the chosen one and of each
    other is said.
    """
    from reports.cli.output_paths import default_output

    out = out or default_output((source, target), "map")
    check_map_outputs(out, picture, view, (source, target))
    kind = matched_on(on, out, repair)
    with steps(quiet, STEPS) as step:
        next(step)
        from reports.cli.cloud_files import read_thinned

        here, there = (read_thinned(path, points, seed, repair, kind, columns) for path in (source, target))
        next(step)
        from evaluation.methods.base import MethodInput
        from evaluation.methods.catalogue import create, missing

        matcher = create(method, parsed(settings, listed({"method": method})))
        if lacking := missing(method):
            raise Failure(lacking)
        if matcher.uses_truth:
            raise Failure(f"method {method!r} looks at the ground truth, which files of clouds do not hold")
        next(step)
        clouds = here, there
        built = operators_of(clouds, matcher.operators, modes, device, departures)
        sides = [
            MethodInput(name=path.stem, scan=cloud.scan, operators=operators)
            for path, cloud, operators in zip((source, target), clouds, built, strict=True)
        ]
        next(step)
        found = matcher.match(sides[0], sides[1], seed=seed)
        next(step)
        about = {"method": method, "seed": seed, "device": device}
        names = source.name, target.name
        whole = write_map(out, clouds, names, found, about)
        if picture is not None:
            draw_map(picture, clouds, names, found)
        if view is not None:
            medial = (sides[0].operators.get("medial"), sides[1].operators.get("medial"))
            show_map(view, clouds, names, found, medial)
        written: list[Path] = []
        if alternatives:
            written = write_alternatives(out, picture, clouds, (source, target), found, about)
    doubts = said_of_alternatives(found, there.scan.points, written, picture is not None and bool(written))
    likely = "" if doubts or isnan(found.probability) else f"; probability of the map {found.probability:.2f}"
    say(quiet, f"{summary(whole, len(found))}{likely}{said_of_kinds(clouds)}; written to {out}")
    for line in doubts:
        say(quiet, line)
    if alternatives and not written:
        say(quiet, "no alternative to write: no other map is probable enough")
    shown = [str(each) for each in (picture, view) if each is not None]
    if shown:
        say(quiet, f"drawn: {', '.join(shown)}")
    elif out.suffix == ".npz":
        say(quiet, f"to look at it: --picture FILE, --view FILE, or medialbench.plot({str(out)!r}) in Python")
