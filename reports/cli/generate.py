"""``medialbench generate``: training data, scans with ground truth in shards."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from reports.cli.cluster_options import cluster_options, tls_files
from reports.cli.console import Command, Failure, Interrupted, result_console, say
from reports.cli.preset_names import preset_names
from reports.cli.progress import clock, sweep_progress

if TYPE_CHECKING:
    from evaluation.generation.generate import GenerationResult
    from evaluation.generation.generation_config import GenerationConfig

SHARD_SIZE = 100
"""As `evaluation.generation.generate.SHARD_SIZE`, without the packages that it loads."""


@click.command(cls=Command, short_help="Make training data: scans with ground truth in shards.")
@click.argument("config", metavar="PRESET|CONFIG.toml")
@click.option(
    "-n", "--samples", type=click.IntRange(min=1), required=True, help="Number of scans, of all splits."
)
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), help="Folder of the shards.  [default: training/NAME]"
)
@click.option(
    "--shard-size",
    type=click.IntRange(min=1),
    default=SHARD_SIZE,
    show_default=True,
    help="Scans per shard.",
)
@cluster_options
@click.option("--force", is_flag=True, help="Remove what was generated in the folder, and make all again.")
@click.option("--dry-run", is_flag=True, help="Say what would be made, and make nothing.")
def generate(
    config: str,
    samples: int,
    out: Path | None,
    shard_size: int,
    jobs: int | None,
    scheduler: str | None,
    tls_ca: str | None,
    tls_cert: str | None,
    tls_key: str | None,
    dashboard: bool,
    force: bool,
    dry_run: bool,
    quiet: bool,
) -> None:
    """Make scans with ground truth at scale: a PRESET or what a TOML file describes.

    PRESET is one of PRESETS. docs/training-data.md describes the file and the shards.

    Writes tar files that WebDataset and plain tarfile read, with a datasheet. Every scan is a pure function
    of the settings and its number: the same command goes on after an interruption, makes damaged shards
    again, and with a larger -n adds to what is there.
    """
    from datasets_gen.paths import safe_name
    from evaluation.generation.generation_config import GenerationConfig
    from reports.cli.output_paths import check_output_folder

    settings = GenerationConfig.load(config)
    folder = out or Path("training") / safe_name(settings.name)
    check_output_folder(folder)
    if dry_run:
        _preview(settings, folder, samples, shard_size, jobs, force)
        return
    cluster = {"jobs": jobs, "scheduler": scheduler, "tls": tls_files(tls_ca, tls_cert, tls_key, scheduler)}
    result = _generated(
        settings,
        folder,
        samples,
        quiet,
        shard_size=shard_size,
        **cluster,
        dashboard=dashboard,
        force=force,
    )
    _report(result, quiet)


generate.help = str(generate.help).replace("PRESETS", ", ".join(preset_names("evaluation", "generation")))


def _generated(
    settings: "GenerationConfig", folder: Path, samples: int, quiet: bool, **options: Any
) -> "GenerationResult":
    from evaluation.generation.generate import generate as make

    os.environ.setdefault("PYTHONWARNINGS", "ignore")  # of libraries in the workers
    say(quiet, f"{settings.name}: {settings.description}" if settings.description else settings.name)
    try:
        return make(settings, folder, samples, progress=sweep_progress(quiet), **options)
    except KeyboardInterrupt as stop:
        raise Interrupted(
            f"interrupted; finished shards are in {str(folder)!r}, the same command goes on"
        ) from stop


def _report(result: "GenerationResult", quiet: bool) -> None:
    """What is there, where its datasheet is, and a failure that counts what is missing."""
    rate = f", {result.made / result.seconds:.2f} per second" if result.made else ""
    size = sum(path.stat().st_size for path in result.folder.glob("*.tar")) / 1e6
    say(quiet, f"{result.samples:,} samples, {size:,.1f} MB; {result.made:,} made now{rate}")
    result_console().print(str(result.folder / "DATASHEET.md"), markup=False, soft_wrap=True)
    if result.failures:
        where = str(result.folder / "failures.csv")
        lost = result.planned - result.samples
        raise Failure(
            f"{lost} of {result.planned} samples are missing, listed in {where}; {result.failures[0]}"
        )


def _preview(
    settings: "GenerationConfig",
    folder: Path,
    samples: int,
    shard_size: int,
    jobs: int | None,
    force: bool,
) -> None:
    from datasets_gen.clouds.point_cloud import counted
    from evaluation.generation.generate import preview_generation

    outlook = preview_generation(settings, folder, samples, shard_size=shard_size, jobs=jobs, force=force)
    print_line = result_console().print
    for each in outlook.plan.samples.sets:
        poses = {split: len(each.poses(split)) for split in ("train", "val")}
        people = len(set(each.individuals.values()))
        print_line(
            f"{each.name}: {people} individuals, {len(each.validation)} of them to validate with; "
            f"poses: {poses['train']} to train, {poses['val']} to validate",
            markup=False,
        )
    counts = outlook.plan.counts
    print_line(f"{counts['train']} samples to train with, {counts['val']} to validate with")
    print_line(
        f"{outlook.waiting} shards to make, {outlook.stored} are there; at most {outlook.megabytes:,.0f} MB"
    )
    if outlook.waiting:
        print_line(f"about {clock(outlook.seconds)} with {counted(outlook.workers, 'worker')}")
