"""What ``medialbench match`` and ``medialbench symmetry`` share: options, and the map that they write."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from reports.cli.set_options import value_of

if TYPE_CHECKING:
    from medial import Diffusion, Matching
    from reports.cli.cloud_files import On, ThinnedCloud
    from reports.cli.setting_list import Setting

POINTS = 8000
MODES = 300
SIDES = ("source", "target")


def map_options(command: Callable[..., None]) -> Callable[..., None]:
    """Add the options of both commands."""
    for option in (
        click.option(
            "--picture",
            type=click.Path(path_type=Path),
            metavar="FILE.png",
            help="Also draw the map as colours, with landmarks and confidence (.png or .pdf).",
        ),
        click.option(
            "--view",
            type=click.Path(path_type=Path),
            metavar="FILE.html",
            help="Also write a page that shows the map in 3D: turn it, tap a point to see its match.",
        ),
        click.option("--repair", is_flag=True, help="Of a mesh, go on with the largest component."),
        click.option(
            "--on",
            type=click.Choice(["vertices", "samples"]),
            help="What of a mesh is matched: each vertex of the file, or samples of its surface.  [default: "
            "vertices for maps in .txt, .csv, .map, .vts and .mat, samples for .npz]",
        ),
        click.option(
            "--columns",
            metavar='"x y z nx ny nz"',
            help="Names of the columns of a text; - for one to leave out.  [default: told by the file]",
        ),
        click.option("--seed", default=0, show_default=True, help="Of samples and restarts."),
        click.option(
            "--modes",
            default=MODES,
            show_default=True,
            type=click.IntRange(min=2),
            help="Eigenfunctions to use.",
        ),
        click.option(
            "--device",
            default="cpu",
            show_default=True,
            help="Where operators are built: cpu, or cuda on a GPU; see medialbench doctor.",
        ),
        click.option(
            "--departures",
            metavar="all|none|{NAME=false}",
            default="all",
            show_default=True,
            callback=lambda _context, _option, text: value_of(text),
            help="From the paper: none is the paper as written, slow from 2,000 points on (docs/paper.md).",
        ),
        click.option(
            "--points",
            default=POINTS,
            show_default=True,
            type=click.IntRange(min=1),
            help="Points of a cloud to match, evenly spread; the others follow their nearest neighbour.",
        ),
    ):
        command = option(command)
    return command


def matched_on(on: "On | None", out: Path, repair: bool) -> "On":
    """What of a mesh is matched: a map that holds bare indices is for the vertices of the user's file."""
    return on or ("samples" if repair or out.suffix.lower() == ".npz" else "vertices")


def said_of_kinds(clouds: tuple["ThinnedCloud", "ThinnedCloud"]) -> str:
    """Whose indices a map holds, where meshes were matched: ``; source: samples, target: 3,200 vertices``."""
    if all(cloud.what == "points" for cloud in clouds):
        return ""
    said = (f"{side}: {len(c.points):,} {c.what}" for side, c in zip(SIDES, clouds, strict=True))
    return f"; {', '.join(said)}"


def matcher_settings() -> list["Setting"]:
    """The settings of the matcher; departures have an option of their own."""
    from medial import MatchConfig
    from reports.cli.setting_list import settings_of

    return settings_of(MatchConfig, ("departures",))


def check_map_outputs(out: Path, picture: Path | None, view: Path | None, inputs: tuple[Path, ...]) -> None:
    """Raise InputError if the map, its picture or its page cannot be written."""
    from datasets_gen.correspondences.writing import WRITTEN
    from reports.cli.output_paths import check_output_file

    check_output_file(out, tuple(suffix for suffix in WRITTEN if suffix != ".corr"), inputs)
    if picture is not None:
        check_output_file(picture, (".png", ".pdf"), inputs)
    if view is not None:
        check_output_file(view, (".html",), inputs)


def operator_of(cloud: "ThinnedCloud", name: str, modes: int, **settings: Any) -> "Diffusion":
    """An operator on the matched points of a cloud; settings as of `Diffusion.from_points`."""
    from medial import Diffusion

    scan = cloud.scan
    return Diffusion.from_points(scan.points, scan.normals, operator=name, modes=modes, **settings)


def operators_of(
    clouds: tuple["ThinnedCloud", "ThinnedCloud"],
    names: Sequence[str],
    modes: int,
    device: str,
    departures: Any,
) -> tuple[dict[str, "Diffusion"], dict[str, "Diffusion"]]:
    """The operators of these names on both clouds, made side by side."""
    from medial.side_by_side import side_by_side

    def made(cloud: "ThinnedCloud") -> dict[str, "Diffusion"]:
        return {name: operator_of(cloud, name, modes, device=device, departures=departures) for name in names}

    here, there = clouds
    return side_by_side(made, (here,), (there,), device)


def write_map(
    out: Path,
    clouds: tuple["ThinnedCloud", "ThinnedCloud"],
    names: tuple[str, str],
    found: "Matching",
    about: dict[str, Any],
) -> "Matching":
    """Carry a map from the matched points to all points of the files, and save it in the format of `out`."""
    source, target = clouds
    whole = found.extended(source.nearest, source.kept, target.kept, source.stray)
    kinds = {side: c.what for side, c in zip(SIDES, clouds, strict=True) if c.what != "points"}
    whole = replace(whole, source_points=source.points, target_points=target.points, about=about | kinds)
    if out.suffix.lower() == ".npz":
        whole.save(out)
    else:
        from datasets_gen.correspondences.point_map import PointMap
        from datasets_gen.correspondences.writing import write_map as write_file

        write_file(PointMap(whole.source_to_target, confidence=whole.confidence), out, names=names)
    return whole


def show_map(
    view: Path,
    clouds: tuple["ThinnedCloud", "ThinnedCloud"],
    names: tuple[str, str],
    found: "Matching",
    operators: tuple["Diffusion | None", "Diffusion | None"],
) -> None:
    """Write the page that shows the map between the matched points."""
    from reports.viewer.view_page import write_view
    from reports.viewer.views import view_of_map

    write_view(view_of_map((clouds[0].scan, clouds[1].scan), names, found, operators), view)


def map_heading(found: "Matching", name: str = "map") -> str:
    """Name and probability of a map; empty for the only map of a pair where that is unknown."""
    if isfinite(found.probability):
        return f"{name}, probability {found.probability:.2f}"
    return "" if name == "map" else name


def draw_map(
    picture: Path,
    clouds: tuple["ThinnedCloud", "ThinnedCloud"],
    names: tuple[str, str],
    found: "Matching",
    name: str = "map",
) -> None:
    """Draw the map between the matched points into a file; it says its name, and its probability if known."""
    from reports.figures.cloud_drawing import DrawnCloud
    from reports.figures.dense_map import dense_map
    from reports.figures.style import save

    here, there = (
        DrawnCloud(c.scan.points, c.scan.normals, name) for c, name in zip(clouds, names, strict=True)
    )
    up = "xyz".index(clouds[0].scan.config.up)
    figure = dense_map(
        here,
        there,
        found.source_to_target,
        found.confidence,
        found.landmarks,
        up=up,
        heading=map_heading(found, name),
    )
    save(figure, picture.parent, picture.stem, formats=(picture.suffix.lower(),))


def summary(whole: "Matching", matched: int) -> str:
    """How many points were matched and how surely.

    Parameters
    ----------
    whole
        The map of all points.
    matched
        Number of source points that were matched; the others follow their nearest neighbour.
    """
    from medial.matching.result import CONFIDENT

    sure = 100 * float((whole.confidence >= CONFIDENT).mean())
    counts = (
        f"{matched:,} points; extended to all {len(whole):,}"
        if matched < len(whole)
        else f"all {matched:,} points"
    )
    return f"Matched {counts}; confident on {sure:.0f} % (confidence of at least {CONFIDENT:g})"
