"""``medialbench symmetry``: the intrinsic symmetry of a cloud in a file."""

from pathlib import Path
from typing import Any

import click

from reports.cli.console import Command, say
from reports.cli.map_options import (
    check_map_outputs,
    draw_map,
    map_options,
    operator_of,
    summary,
    write_map,
)
from reports.cli.progress import steps

STEPS = (("reading", 1), ("loading libraries", 2), ("operator", 4), ("matching", 16), ("writing", 1))


@click.command(cls=Command, short_help="Find the intrinsic symmetry of a cloud.")
@click.argument("cloud", type=click.Path(path_type=Path))
@map_options
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), help="Map to write.  [default: CLOUD.symmetry.npz]"
)
def symmetry(
    cloud: Path,
    out: Path | None,
    points: int,
    modes: int,
    device: str,
    departures: Any,
    seed: int,
    repair: bool,
    picture: Path | None,
    quiet: bool,
) -> None:
    """Find the intrinsic symmetry of CLOUD: for every point, its mirror image on the same cloud (Sec. 5.2).

    The map has the same form as that of match, with CLOUD as source and as target.
    """
    from reports.cli.output_paths import default_output

    out = out or default_output((cloud,), "symmetry")
    check_map_outputs(out, picture, (cloud,))
    with steps(quiet, STEPS) as step:
        next(step)
        from reports.cli.cloud_files import read_thinned

        whole = read_thinned(cloud, points, seed, repair)
        next(step)
        from medial import intrinsic_symmetry

        next(step)
        operator = operator_of(whole, "medial", modes, device=device, departures=departures)
        next(step)
        found = intrinsic_symmetry(operator, seed=seed)
        next(step)
        about = {"method": "symmetry", "seed": seed, "device": device}
        extended = write_map(out, whole, whole, found, about)
        if picture is not None:
            draw_map(picture, (whole, whole), (cloud.name, cloud.name), found)
    say(quiet, f"{summary(extended, len(found))}; written to {out}")
