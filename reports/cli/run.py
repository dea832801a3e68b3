"""``medialbench run``: an experiment from shapes to report."""

import os
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from reports.cli.cluster_options import cluster_options, tls_files
from reports.cli.console import Command, Failure, Interrupted, print_lines, result_console, say
from reports.cli.experiment_argument import check_experiment_kept, load_experiment, results_of
from reports.cli.preset_names import preset_names
from reports.cli.progress import clock, sweep_progress

if TYPE_CHECKING:
    from evaluation import Experiment, ResultsStore


@click.command(cls=Command, short_help="Run an experiment from shapes to report.")
@click.argument("experiment", metavar="PRESET|CONFIG.toml|RESULTS")
@click.option("-o", "--out", type=click.Path(path_type=Path), help="Results folder.  [default: results/NAME]")
@click.option(
    "--dataset",
    "datasets",
    multiple=True,
    metavar="NAME|FOLDER",
    help="Use this instead of the experiment's data sets: built in, or a folder of poses; may be repeated.",
)
@click.option(
    "--poses",
    metavar="N|NAME,NAME",
    help="Use N poses of each data set, or these; instead of the experiment's.",
)
@click.option(
    "--seeds",
    type=click.IntRange(min=1, max=10_000),
    metavar="N",
    help="Use the seeds 0 to N - 1 instead of the experiment's.",
)
@click.option(
    "--method",
    "methods",
    multiple=True,
    metavar="LABEL|NAME",
    help="Of the experiment's methods use this: by its label, or all of a name; may be repeated.",
)
@cluster_options
@click.option("--force", is_flag=True, help="Run everything again, even what is stored.")
@click.option("--dry-run", is_flag=True, help="Say what would run, and run nothing.")
@click.option(
    "--report/--no-report", "with_report", default=True, help="Whether to write the report.  [default: yes]"
)
def run(
    experiment: str,
    out: Path | None,
    datasets: tuple[str, ...],
    poses: str | None,
    seeds: int | None,
    methods: tuple[str, ...],
    jobs: int | None,
    scheduler: str | None,
    tls_ca: str | None,
    tls_cert: str | None,
    tls_key: str | None,
    dashboard: bool,
    force: bool,
    dry_run: bool,
    with_report: bool,
    quiet: bool,
) -> None:
    """Scan, match, score and report: run a PRESET or an experiment described by a TOML file.

    PRESET is one of PRESETS. docs/evaluation.md describes the file.

    A folder of RESULTS stands for its experiment.toml, and goes on where it stopped. For meshes of your own:
    medialbench run quick --dataset FOLDER, with --dry-run to see first how long it takes. The preset matching
    compares every method on five kinds of scans, for hours; medialbench doctor says what
    some of them need.

    Results that are stored in the folder already are used again, so the same command goes on after an
    interruption. Ends with the leaderboard and the path of the report.
    """
    from datasets_gen.paths import safe_name
    from reports.cli.output_paths import check_output_folder

    settings = load_experiment(experiment, datasets, seeds, poses, methods)
    folder = out or results_of(experiment) or Path("results") / safe_name(settings.name)
    if dry_run:
        _preview(settings, folder, jobs)
        return
    check_output_folder(folder)
    check_experiment_kept(experiment, settings, folder)
    cluster = {"jobs": jobs, "scheduler": scheduler, "tls": tls_files(tls_ca, tls_cert, tls_key, scheduler)}
    store = _sweep(settings, folder, quiet, **cluster, dashboard=dashboard, force=force)
    _finish(store, with_report, quiet, jobs)


run.help = str(run.help).replace("PRESETS", ", ".join(preset_names("evaluation", "protocols")))


def _sweep(settings: "Experiment", folder: Path, quiet: bool, **options: Any) -> "ResultsStore":
    from evaluation import run as run_experiment

    os.environ.setdefault("PYTHONWARNINGS", "ignore")  # of libraries in the workers
    say(quiet, f"{settings.name}: {settings.description}" if settings.description else settings.name)
    try:
        return run_experiment(settings, folder, progress=sweep_progress(quiet), **options)
    except KeyboardInterrupt as stop:
        raise Interrupted(
            f"interrupted; results so far are in {str(folder)!r}, the same command goes on"
        ) from stop


def _preview(settings: "Experiment", folder: Path, jobs: int | None) -> None:
    from datasets_gen.clouds.point_cloud import counted
    from evaluation import preview

    outlook = preview(settings, folder, jobs=jobs)
    say_result = result_console().print
    for name, poses in outlook.poses.items():
        say_result(f"{name}: {', '.join(poses)}", markup=False)
    for stage, count in outlook.waiting.items():
        say_result(f"{stage:10} {count:6} to run", markup=False)
    stored = "1 result is" if outlook.stored == 1 else f"{outlook.stored} results are"
    say_result(f"{stored} stored already; the table would have {counted(outlook.rows, 'row')}")
    total = sum(outlook.waiting.values())
    if total:
        work, workers = counted(total, "task"), counted(outlook.workers, "worker")
        say_result(f"{work} to run, about {clock(outlook.seconds)} with {workers}")
    else:
        say_result("nothing to run: every result of this experiment is stored")
    for label, reason in outlook.unavailable.items():
        say_result(f"{label}: would not run: {reason}", markup=False)


def _finish(store: "ResultsStore", with_report: bool, quiet: bool, jobs: int | None) -> None:
    """Leaderboard, report, and a failure that counts the failures."""
    from reports.tables.leaderboard import ceilings, leaderboard, with_numpy_types

    table, page = with_numpy_types(store.table()), None
    if with_report and len(table):
        from reports.page.freshness import PAIRS, is_made

        page = store.folder / "report" / "index.html"
        if not is_made(store, page.parent, PAIRS):
            from reports.cli.report import write_report

            page = write_report(store.folder, None, PAIRS, quiet, jobs)
    board = leaderboard(table, ceilings(store.settings))
    if len(board) and not quiet:
        from reports.tables.terminal import leaderboard_lines

        print_lines(leaderboard_lines(board, result_console().width))
    if page is not None:
        say(quiet, "report:")
        result_console().print(str(page), markup=False, soft_wrap=True)
    failures = store.failures()
    for _, row in failures[failures["kind"] == "unavailable"].iterrows():
        say(quiet, f"{row['label']} did not run: {row['reason']}")
    failed = failures[failures["kind"] != "unavailable"]
    if len(failed):
        first = failed.iloc[0]
        where = str(store.folder / "failures.csv")
        raise Failure(
            f"{len(failed)} tasks have no result, listed in {where}, tracebacks are in 'failures' beside it; "
            f"{first['label']}: {first['reason']}"
        )
