"""``medialbench skeleton``: the curve skeleton of a cloud in a file."""

from pathlib import Path

import click

from reports.cli.console import Command, say
from reports.cli.progress import steps

METHODS = ("rosa", "medial", "local-separators")
STEPS = (("reading", 1), ("loading libraries", 2), ("skeleton", 8), ("writing", 1))


@click.command(cls=Command, short_help="Find the curve skeleton of a cloud.")
@click.argument("cloud", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    help="Skeleton to write: .npz, .ply (edges), .json or .obj (lines).  [default: CLOUD.skeleton.npz]",
)
@click.option(
    "--method",
    type=click.Choice(METHODS),
    default=METHODS[0],
    show_default=True,
    help="rosa [TZCO09], medial (of the medial centres, Eq. 9), or local-separators (needs pygel3d).",
)
@click.option(
    "--points",
    default=8000,
    show_default=True,
    type=click.IntRange(min=1),
    help="Points of the cloud that are used, evenly spread; the others belong to their nearest one's node.",
)
@click.option("--seed", default=0, show_default=True, help="Of the samples of a mesh and of the spread.")
@click.option("--repair", is_flag=True, help="Of a mesh: go on with the largest component.")
@click.option(
    "--picture", type=click.Path(path_type=Path), metavar="FILE.png", help="Also draw it (.png or .pdf)."
)
@click.option(
    "--view",
    type=click.Path(path_type=Path),
    metavar="FILE.html",
    help="Also write a page in 3D: the slider of the centres moves every point to its place on the skeleton.",
)
def skeleton(
    cloud: Path,
    out: Path | None,
    method: str,
    points: int,
    seed: int,
    repair: bool,
    picture: Path | None,
    view: Path | None,
    quiet: bool,
) -> None:
    """Find the curve skeleton of CLOUD: curves through the middle of its limbs, joined as the limbs are.

    Where nothing is tubular, as on a sheet or a ball, the skeleton has no curve, and the reason is said.
    """
    from reports.cli.output_paths import check_output_file, default_output

    out = out or default_output((cloud,), "skeleton")
    check_output_file(out, (".npz", ".ply", ".json", ".obj"), (cloud,))
    if picture is not None:
        check_output_file(picture, (".png", ".pdf"), (cloud,))
    if view is not None:
        check_output_file(view, (".html",), (cloud,))
    with steps(quiet, STEPS) as step:
        next(step)
        from reports.cli.cloud_files import read_thinned

        whole = read_thinned(cloud, points, seed, repair)
        next(step)
        from medial.skeletons import skeleton_of, write_skeleton
        from reports.skeleton_outputs import carried, draw_skeleton, show_skeleton

        next(step)
        found = skeleton_of(whole.scan.points, whole.scan.normals, method)
        next(step)
        write_skeleton(out, carried(found, whole))
        if picture is not None:
            draw_skeleton(picture, whole.scan, cloud.name, found)
        if view is not None:
            show_skeleton(view, whole.scan, cloud.name, found)
    tips, joints = (int((found.kinds == kind).sum()) for kind in ("tip", "joint"))
    said = f"{len(found)} nodes, {tips} tips, {joints} joints" if len(found.edges) else found.reason
    say(quiet, f"{said}; written to {out}")
