"""``medialbench scan``: a mesh through the simulated laser scanner."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from reports.cli.console import say
from reports.cli.preset_names import preset_names
from reports.cli.progress import steps
from reports.cli.set_options import CommandWithSettings, merged, value_of

if TYPE_CHECKING:
    from reports.cli.setting_list import Setting

HUGE = 200_000
"""Points from which on a scan is larger than what most programs work with."""


def listed(given: Mapping[str, Any]) -> list["Setting"]:
    """What ``--set`` takes."""
    from reports.cli.setting_list import settings_of
    from scanner_sim import ScannerConfig

    return settings_of(ScannerConfig)


@click.command(
    cls=CommandWithSettings,
    listed=listed,
    about="Another setting of scanner_sim.ScannerConfig, as noise=0.1",
    short_help="Scan a mesh with the simulated laser scanner.",
)
@click.argument("mesh", type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    help="Scan to write: .npz (everything), .ply, .las, .laz or .e57.  [default: MESH.scan.npz]",
)
@click.option(
    "--preset",
    metavar="NAME|FILE.toml",
    help=f"Settings of a known scanner: {', '.join(preset_names())}; or of your own, in a table [scanner].",
)
@click.option(
    "-t",
    "--peak-threshold",
    type=float,
    help="Smallest accepted laser peak, in (0, 1]; higher loses more surface.  [default: preset's, or 0.1]",
)
@click.option(
    "--views",
    help="Viewpoints: a number, sphere:N, ring:N, turntable:N@ELEVATION, opposed, one side (front:N, back:N, "
    "left:N, right:N), [[x, y, z], ...] or 4 x 4 matrices.  [default: preset's, or 10]",
)
@click.option(
    "--points", type=click.IntRange(min=1), help="Keep this many points, evenly spread.  [default: all]"
)
@click.option("--seed", default=0, show_default=True, help="Of the noise and of the even spread.")
@click.option("--repair", is_flag=True, help="Go on with the largest component and without degenerate faces.")
@click.option(
    "--preview",
    type=click.Path(path_type=Path),
    metavar="FILE.png",
    help="Also draw a contact sheet: rig, camera, stripe, intensity, verdict on every pixel (.png or .pdf).",
)
@click.option(
    "--range-images",
    type=click.Path(path_type=Path),
    metavar="DIR",
    help="Also write a 16-bit range image per view, and the cameras (cameras.json, transforms.json).",
)
@click.option(
    "--view",
    type=click.Path(path_type=Path),
    metavar="FILE.html",
    help="Also write a page that shows the scan in 3D, with a slider for the peak threshold.",
)
@click.option(
    "--truth",
    type=click.Path(path_type=Path),
    metavar="FILE.ply",
    help="Also write the complete surface as points that know whether the scan has seen them.",
)
def scan(
    mesh: Path,
    out: Path | None,
    preset: str | None,
    peak_threshold: float | None,
    views: str | None,
    points: int | None,
    seed: int,
    settings: tuple[str, ...],
    repair: bool,
    preview: Path | None,
    range_images: Path | None,
    view: Path | None,
    truth: Path | None,
    quiet: bool,
) -> None:
    """Scan MESH (.ply, .obj or .off) with the simulated laser scanner.

    The mesh may be open, in pieces, or otherwise unfit for ground truth; views that see nothing of it are
    named and left out. Every point of the scan knows its face and barycentric coordinates on the mesh.
    """
    from datasets_gen import load_mesh
    from datasets_gen.meshes.colours import colours_of
    from reports.cli.output_paths import check_output_file, check_output_folder, default_output

    out = out or default_output((mesh,), "scan")
    check_output_file(out, (".npz", ".ply", ".las", ".laz", ".e57"), (mesh,))
    if preview is not None:
        check_output_file(preview, (".png", ".pdf", ".svg"), (mesh,))
    if range_images is not None:
        check_output_folder(range_images)
    if view is not None:
        check_output_file(view, (".html",), (mesh,))
    if truth is not None:
        check_output_file(truth, (".ply",), (mesh,))
        if truth.absolute() == out.absolute():
            raise click.UsageError(f"--truth and -o are both {str(truth)!r}; choose another name for one")
    chosen_views = None if views is None else value_of(views)
    given = merged({"views": chosen_views, "peak_threshold": peak_threshold}, settings, listed({}))
    with steps(
        quiet, [("reading the mesh", 1), ("starting the scanner", 2), ("scanning", 10), ("writing", 2)]
    ) as step:
        next(step)
        shape = load_mesh(mesh, repair=repair, strict=False)
        next(step)
        import scanner_sim
        from scanner_sim.output.packages import check_packages
        from scanner_sim.output.truth import write_truth

        check_packages(out)
        chosen = {} if preset is None else {"preset": preset}
        config = scanner_sim.ScannerConfig.from_dict(chosen | given)
        colours = colours_of(mesh) if config.material == "colours" else None
        next(step)
        whole = scanner_sim.scan(shape, config, seed, colours)
        missing = 1 - scanner_sim.coverage(whole, shape)
        cloud = whole if points is None else whole.subsample(points, seed)
        next(step)
        cloud.save(out)
        if view is not None:
            from reports.viewer.view_page import write_view
            from reports.viewer.views import view_of_scan

            write_view(view_of_scan(cloud, mesh.name), view)
        if preview is not None:
            scanner_sim.write_contact_sheet(shape, preview, config, seed, attributes=colours)
        if range_images is not None:
            scanner_sim.write_range_images(whole, range_images)
        if truth is not None:
            write_truth(truth, whole, shape)
    if len(cloud) > HUGE:
        say(
            quiet,
            f"{len(cloud):,} points are many: --points 20000 keeps as many, evenly spread, and a lower "
            "--set resolution or fewer --views scans faster",
        )
    kept = f", {len(cloud):,} kept" if len(cloud) < len(whole) else ""
    say(
        quiet,
        f"{len(whole):,} points{kept}; {100 * missing:.1f} % of the surface is missing; written to {out}",
    )
