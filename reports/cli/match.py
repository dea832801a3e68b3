"""``medialbench match`` and ``medialbench symmetry``: correspondences of clouds in files."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from reports.cli.console import Command, Failure, note, steps
from reports.cli.set_options import parsed

if TYPE_CHECKING:
    from medial import Matching
    from reports.cli.cloud_files import FileCloud

POINTS = 8000
MODES = 300


def _shared(command: Callable[..., None]) -> Callable[..., None]:
    """Options of both commands."""
    for option in (
        click.option(
            "--picture",
            type=click.Path(path_type=Path),
            metavar="FILE.png",
            help="Also draw the map as colours, with landmarks and confidence (.png or .pdf).",
        ),
        click.option("--repair", is_flag=True, help="Of a mesh, go on with the largest component."),
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
            "--points",
            default=POINTS,
            show_default=True,
            type=click.IntRange(min=1),
            help="Points of a cloud to match, evenly spread; the others follow their nearest neighbour.",
        ),
        click.option(
            "-o", "--out", required=True, type=click.Path(path_type=Path), help="Map to write, .npz."
        ),
    ):
        command = option(command)
    return command


@click.command(cls=Command, short_help="Match two clouds point by point.")
@click.argument("source", type=click.Path(path_type=Path))
@click.argument("target", type=click.Path(path_type=Path))
@_shared
@click.option(
    "--method", default="medial", show_default=True, help="Matching method; see medialbench doctor."
)
@click.option(
    "--set",
    "settings",
    multiple=True,
    metavar="NAME=VALUE",
    help="An option of the method, as config=paper; may be repeated.",
)
def match(
    source: Path,
    target: Path,
    out: Path,
    points: int,
    modes: int,
    device: str,
    seed: int,
    repair: bool,
    picture: Path | None,
    method: str,
    settings: tuple[str, ...],
    quiet: bool,
) -> None:
    """Match two clouds: for every point of SOURCE, a point of TARGET.

    Both are .npz scans; .ply, .obj, .off or .xyz clouds (normals are estimated where there are none); or
    meshes, which are sampled. The map holds source_to_target (for each of source_points an index into
    target_points), confidence in [0, 1] and landmarks (pairs of such indices).
    """
    _check_outputs(out, picture)
    names = [
        ("reading", 1),
        ("loading libraries", 2),
        ("operator of the source", 8),
        ("operator of the target", 8),
    ]
    with steps(quiet, [*names, ("matching", 6), ("writing", 1)]) as step:
        next(step)
        from reports.cli.cloud_files import read_cloud

        clouds = [read_cloud(path, points, seed, repair) for path in (source, target)]
        next(step)
        from evaluation.methods.base import Cloud
        from evaluation.methods.registry import create, missing

        matcher = create(method, parsed(settings))
        if lacking := missing(method):
            raise Failure(lacking)
        if matcher.uses_truth:
            raise Failure(f"method {method!r} looks at the ground truth, which files of clouds do not hold")
        sides: list[Cloud] = []
        for cloud, path in zip(clouds, (source, target), strict=True):
            next(step)
            operators = {name: _operator(cloud, name, modes, device) for name in matcher.operators}
            sides.append(Cloud(name=path.stem, scan=cloud.scan, operators=operators))
        next(step)
        found = matcher.match(sides[0], sides[1], seed=seed)
        next(step)
        about = {"method": method, "seed": seed, "device": device}
        _write(out, clouds[0], clouds[1], found, about)
        if picture is not None:
            _draw(picture, clouds, (source.name, target.name), found)
    note(quiet, f"{_summary(found, clouds[0])}; written to {out}")


@click.command(cls=Command, short_help="Find the intrinsic symmetry of a cloud.")
@click.argument("cloud", type=click.Path(path_type=Path))
@_shared
def symmetry(
    cloud: Path,
    out: Path,
    points: int,
    modes: int,
    device: str,
    seed: int,
    repair: bool,
    picture: Path | None,
    quiet: bool,
) -> None:
    """Find the intrinsic symmetry of CLOUD: for every point, its mirror image on the same cloud (Sec. 5.2).

    The map has the same form as that of match, with CLOUD as source and as target.
    """
    _check_outputs(out, picture)
    named = [("reading", 1), ("loading libraries", 2), ("operator", 8), ("matching", 6), ("writing", 1)]
    with steps(quiet, named) as step:
        next(step)
        from reports.cli.cloud_files import read_cloud

        whole = read_cloud(cloud, points, seed, repair)
        next(step)
        from medial import intrinsic_symmetry

        next(step)
        operator = _operator(whole, "medial", modes, device)
        next(step)
        found = intrinsic_symmetry(operator, seed=seed)
        next(step)
        _write(out, whole, whole, found, {"method": "symmetry", "seed": seed, "device": device})
        if picture is not None:
            _draw(picture, (whole, whole), (cloud.name, cloud.name), found)
    note(quiet, f"{_summary(found, whole)}; written to {out}")


def _operator(cloud: "FileCloud", name: str, modes: int, device: str) -> Any:
    from medial import Diffusion

    scan = cloud.scan
    return Diffusion.from_points(scan.points, scan.normals, operator=name, modes=modes, device=device)


def _write(
    out: Path, source: "FileCloud", target: "FileCloud", found: "Matching", about: dict[str, Any]
) -> None:
    """Carry a map from the matched points to all points of the files, and save it."""
    import numpy as np

    from datasets_gen.records import save_record

    image = np.where(found.source_to_target < 0, -1, target.kept[found.source_to_target])[source.nearest]
    landmarks = np.column_stack([source.kept[found.landmarks[:, 0]], target.kept[found.landmarks[:, 1]]])
    arrays = {
        "source_to_target": image.astype(np.int64),
        "confidence": found.confidence[source.nearest],
        "landmarks": landmarks.astype(np.int64),
        "source_points": source.points,
        "target_points": target.points,
    }
    save_record(out, "Correspondence", arrays, {"cost": float(found.cost), "flip": found.flip, **about})


def _check_outputs(out: Path, picture: Path | None) -> None:
    from reports.cli.output_paths import check_output_file

    check_output_file(out, (".npz",))
    if picture is not None:
        check_output_file(picture, (".png", ".pdf"))


def _draw(picture: Path, clouds: "Sequence[FileCloud]", names: tuple[str, str], found: "Matching") -> None:
    from reports.figures.correspondence import Cloud
    from reports.figures.dense_map import dense_map
    from reports.figures.style import save

    here, there = (Cloud(c.scan.points, c.scan.normals, name) for c, name in zip(clouds, names, strict=True))
    up = "xyz".index(clouds[0].scan.config.up)
    figure = dense_map(here, there, found.source_to_target, found.confidence, found.landmarks, up=up)
    save(figure, picture.parent, picture.stem, formats=(picture.suffix.lower(),))


def _summary(found: "Matching", source: "FileCloud") -> str:
    import numpy as np

    sure = 100 * float(np.mean(found.confidence >= 0.5))
    matched = f"{len(source.points):,} points mapped from {len(source.scan):,} matched"
    sides = f"{len(found.landmarks)} landmarks, left-right: {found.flip}"
    return f"{matched}, {sides}, {sure:.0f} % of points with confidence of 0.5 or more"
