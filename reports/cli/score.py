"""``medialbench score``: the error of a map that was made anywhere."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from reports.cli.console import Command, result_console, say

if TYPE_CHECKING:
    from datasets_gen import Shape
    from datasets_gen.correspondences.point_map import PointMap
    from scanner_sim import Scan


@click.command(cls=Command, short_help="The error of a map that was made anywhere.")
@click.argument("correspondence", metavar="MAP", type=click.Path(path_type=Path))
@click.option(
    "--target",
    required=True,
    metavar="MESH",
    type=click.Path(path_type=Path),
    help="The mesh that MAP leads to; distances are measured on it.",
)
@click.option(
    "--truth",
    multiple=True,
    metavar="FILE",
    type=click.Path(path_type=Path),
    help="The right map, in any of the formats. Given twice: the maps of a template to the source and to the "
    "target, as a pair of .vts files. Without it, vertex i of the target is right for point i.",
)
@click.option(
    "--scans",
    nargs=2,
    metavar="SOURCE TARGET",
    type=click.Path(path_type=Path),
    help="The two scans between which MAP leads, files of `medialbench scan`: they hold the truth, and MESH "
    "is any pose of their subject.",
)
@click.option(
    "--mirrored",
    multiple=True,
    metavar="FILE",
    type=click.Path(path_type=Path),
    help="The same of the mirror image (_sym, .sym.vts), for the symmetric error.",
)
@click.option(
    "--first-id",
    type=click.IntRange(0, 1),
    help="Index of the first target point in MAP.  [default: as the file or its format says]",
)
@click.option(
    "--area",
    type=click.FloatRange(min=0, min_open=True),
    help="Divide errors by the square root of this area, in squared units of MESH.  [default: that of MESH]",
)
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), help="Also write the errors of all points (.csv)."
)
def score(
    correspondence: Path,
    target: Path,
    truth: tuple[Path, ...],
    scans: tuple[Path, Path] | None,
    mirrored: tuple[Path, ...],
    first_id: int | None,
    area: float | None,
    out: Path | None,
    quiet: bool,
) -> None:
    """Score MAP, which gives a vertex of a target mesh (or a triangle and weights) for each source vertex.

    Reads .npz and .npy (from 0), .txt and .csv (from 0 or 1, which the file or --first-id says), .map (from
    0), .vts and .mat (from 1), .corr and .baryc_gt (triangles from 1, with weights). Errors are geodesic
    distances x 100 / sqrt(area). A point without a match counts like a random one in mean and median, and as
    wrong in the shares (PCK).
    """
    for each, option in ((truth, "--truth"), (mirrored, "--mirrored")):
        if len(each) > 2:
            raise click.UsageError(f"{option} can be given twice at most: template to source, and to target")
    if scans and (truth or mirrored):
        raise click.UsageError("--scans holds the truth; leave out --truth and --mirrored")
    if mirrored and len(mirrored) != len(truth):
        raise click.UsageError("--mirrored takes as many files as --truth")
    from reports.cli.output_paths import check_output_file

    if out is not None:
        check_output_file(out, (".csv",), (correspondence, target, *truth, *mirrored, *(scans or ())))
    from datasets_gen.checks import scannable
    from datasets_gen.correspondences.reading import read_map
    from datasets_gen.meshes.files import read_mesh
    from evaluation.metrics.map_score import score_map, score_scans
    from scanner_sim import Scan

    found = read_map(correspondence, first_id)
    mesh = scannable(read_mesh(target))
    if scans:
        source, goal = Scan.load(scans[0]), Scan.load(scans[1])
        _check_scans(correspondence, source, goal)
        result = score_scans(found, source, goal, mesh, area)
    else:
        right, other = _truth(truth, found, mesh), _truth(mirrored, found, mesh) if mirrored else None
        result = score_map(found, right, mesh, other, area)
    if out is not None:
        _write(out, result.source_ids.tolist(), (100 * result.errors).tolist())
    console = result_console()
    for name, value in result.summary().items():
        shown = f"{value:.3f}" if isinstance(value, float) else str(value)
        console.print(f"{name:<15} {shown:>10}", markup=False, highlight=False)
    if result.elsewhere:
        say(
            quiet,
            f"{result.elsewhere} points are mapped to another piece of the target: counted as unmatched",
        )
    if out is not None:
        say(quiet, f"Errors written to {out}")


def _check_scans(correspondence: Path, source: "Scan", target: "Scan") -> None:
    """Raise InputError if MAP holds the points that it was made of, and they are not those of the scans."""
    import numpy as np

    from reports.given_clouds import check_matched

    if correspondence.suffix.lower() == ".npz":
        with np.load(correspondence, allow_pickle=False) as data:
            for scan, name in ((source, "source"), (target, "target")):
                check_matched(data.get(f"{name}_points"), scan, name)


def _truth(files: tuple[Path, ...], found: "PointMap", mesh: "Shape") -> "PointMap":
    """The right map of as many points as were found."""
    import numpy as np

    from datasets_gen import InputError
    from datasets_gen.correspondences.point_map import PointMap
    from datasets_gen.correspondences.reading import read_map
    from evaluation.metrics.map_score import truth_of_pair

    if not files:
        if len(found) != len(mesh.vertices):
            raise InputError(
                f"the map has {len(found)} points and the target {len(mesh.vertices)} vertices, so point i "
                "is not vertex i; give the right map with --truth, or the matched scans with --scans"
            )
        return PointMap(np.arange(len(found)))
    read = [read_map(path) for path in files]
    return read[0] if len(read) == 1 else truth_of_pair(read[0], read[1], len(found))


def _write(out: Path, points: list[int], errors: list[float]) -> None:
    """A table of points and their errors; empty where there is no match."""
    import csv

    from datasets_gen.records import atomic_path

    with atomic_path(out) as temporary, temporary.open("w", newline="", encoding="utf-8") as stream:
        writer = csv.writer(stream)
        writer.writerow(["source", "error"])
        writer.writerows((i, "" if e != e else f"{e:.6g}") for i, e in zip(points, errors, strict=True))
