"""``medialbench symmetry``: the intrinsic symmetry of a cloud in a file."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from reports.cli.console import say
from reports.cli.map_options import (
    check_map_outputs,
    draw_map,
    map_options,
    matched_on,
    matcher_settings,
    operator_of,
    said_of_kinds,
    show_map,
    summary,
    write_map,
)
from reports.cli.progress import steps
from reports.cli.set_options import CommandWithSettings, parsed

if TYPE_CHECKING:
    from reports.cli.setting_list import Setting

STEPS = (("reading", 1), ("loading libraries", 2), ("operator", 4), ("matching", 16), ("writing", 1))


def listed(given: Mapping[str, Any]) -> list["Setting"]:
    """What ``--set`` takes."""
    from evaluation.methods.spectral import Medial
    from reports.cli.setting_list import settings_of

    return settings_of(Medial, ("settings", "operator")) + matcher_settings()


@click.command(
    cls=CommandWithSettings,
    listed=listed,
    about="A setting of the matcher, as finalists=4",
    short_help="Find the intrinsic symmetry of a cloud.",
)
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
    on: Any,
    columns: str | None,
    picture: Path | None,
    view: Path | None,
    settings: tuple[str, ...],
    quiet: bool,
) -> None:
    """Find the intrinsic symmetry of CLOUD: for every point, its mirror image on the same cloud (Sec. 5.2).

    The map has the same form as that of match, with CLOUD as source and as target.
    """
    from reports.cli.output_paths import default_output

    out = out or default_output((cloud,), "symmetry")
    check_map_outputs(out, picture, view, (cloud,))
    kind = matched_on(on, out, repair)
    with steps(quiet, STEPS) as step:
        next(step)
        from reports.cli.cloud_files import read_thinned

        whole = read_thinned(cloud, points, seed, repair, kind, columns)
        next(step)
        from evaluation.methods.spectral import Medial
        from medial import intrinsic_symmetry

        matcher = Medial.from_options(parsed(settings, listed({})))
        next(step)
        operator = operator_of(whole, "medial", modes, device=device, departures=departures)
        next(step)
        found = intrinsic_symmetry(operator, matcher.match_config(operator.departures), seed)
        next(step)
        about = {"method": "symmetry", "seed": seed, "device": device}
        clouds, names = (whole, whole), (cloud.name, cloud.name)
        extended = write_map(out, clouds, names, found, about)
        if picture is not None:
            draw_map(picture, clouds, names, found)
        if view is not None:
            show_map(view, clouds, names, found, (operator, operator))
    say(quiet, f"{summary(extended, len(found))}{said_of_kinds(clouds)}; written to {out}")
