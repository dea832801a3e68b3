"""``medialbench match``: the correspondence of two clouds in files."""

from pathlib import Path
from typing import Any

import click

from reports.cli.console import Command, Failure, say
from reports.cli.map_alternatives import said_of_alternatives, write_alternatives
from reports.cli.map_options import (
    check_map_outputs,
    draw_map,
    map_options,
    operator_of,
    summary,
    write_map,
)
from reports.cli.progress import steps
from reports.cli.set_options import parsed

STEPS = (
    ("reading", 1),
    ("loading libraries", 2),
    ("operator of the source", 4),
    ("operator of the target", 4),
    ("matching", 16),
    ("writing", 1),
)


@click.command(cls=Command, short_help="Match two clouds point by point.")
@click.argument("source", type=click.Path(path_type=Path))
@click.argument("target", type=click.Path(path_type=Path))
@map_options
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), help="Map to write.  [default: SOURCE-TARGET.map.npz]"
)
@click.option(
    "--method",
    default="medial",
    show_default=True,
    help="Matching method; see medialbench doctor. medial, heat and robust are operator= in Python.",
)
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="NAME=VALUE",
    help="An option of the method, as config=paper (the settings of Sec. 4) or, of the matcher, "
    "'settings={finalists=4}'; may be repeated.",
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
    picture: Path | None,
    method: str,
    settings: tuple[str, ...],
    alternatives: bool,
    quiet: bool,
) -> None:
    """Match two clouds: for every point of SOURCE, a point of TARGET.

    Both are .npz scans; .ply, .obj, .off or .xyz clouds (normals are estimated where there are none); or
    meshes, which are sampled. The map holds source_to_target (for each of source_points an index into
    target_points), confidence in [0, 1] and landmarks (pairs of such indices). Where the clouds leave open
    which map is right, as front for back, the probability of the chosen one and of each other is said.
    """
    from reports.cli.output_paths import default_output

    out = out or default_output((source, target), "map")
    check_map_outputs(out, picture, (source, target))
    with steps(quiet, STEPS) as step:
        next(step)
        from reports.cli.cloud_files import read_thinned

        here, there = (read_thinned(path, points, seed, repair) for path in (source, target))
        next(step)
        from evaluation.methods.base import MethodInput
        from evaluation.methods.catalogue import create, missing

        matcher = create(method, parsed(settings))
        if lacking := missing(method):
            raise Failure(lacking)
        if matcher.uses_truth:
            raise Failure(f"method {method!r} looks at the ground truth, which files of clouds do not hold")
        sides: list[MethodInput] = []
        for cloud, path in ((here, source), (there, target)):
            next(step)
            built = {"device": device, "departures": departures}
            operators = {name: operator_of(cloud, name, modes, **built) for name in matcher.operators}
            sides.append(MethodInput(name=path.stem, scan=cloud.scan, operators=operators))
        next(step)
        found = matcher.match(sides[0], sides[1], seed=seed)
        next(step)
        about = {"method": method, "seed": seed, "device": device}
        whole = write_map(out, here, there, found, about)
        if picture is not None:
            draw_map(picture, (here, there), (source.name, target.name), found)
        written: list[Path] = []
        if alternatives:
            written = write_alternatives(out, picture, (here, there), (source, target), found, about)
    check = "; mirror check undecided" if found.mirror_check == "undecided" else ""
    say(quiet, f"{summary(whole, len(found))}{check}; written to {out}")
    for line in said_of_alternatives(found, written, picture is not None and bool(written)):
        say(quiet, line)
