"""``medialbench run``: an experiment from shapes to report."""

import os
import time
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from reports.cli.console import PLAIN_EVERY, Command, Failure, Interrupted, clock, note, output, remarks, show

if TYPE_CHECKING:
    from evaluation import Experiment, ResultsStore
    from evaluation.running.progress import Forecast, Progress
    from evaluation.running.tasks import Report


@click.command(cls=Command, short_help="Run an experiment from shapes to report.")
@click.argument("experiment", metavar="PRESET|CONFIG.toml")
@click.option("-o", "--out", type=click.Path(path_type=Path), help="Results folder.  [default: results/NAME]")
@click.option(
    "--dataset",
    "datasets",
    multiple=True,
    metavar="NAME|FOLDER",
    help="Use this instead of the experiment's data sets: built in, or a folder of poses; may be repeated.",
)
@click.option(
    "--seeds",
    type=click.IntRange(min=1),
    metavar="N",
    help="Use the seeds 0 to N - 1 instead of the experiment's.",
)
@click.option(
    "-j", "--jobs", type=click.IntRange(min=1), help="Worker processes.  [default: number of processors]"
)
@click.option(
    "--scheduler", metavar="tcp://HOST:PORT", help="Use a running Dask cluster instead of local workers."
)
@click.option("--force", is_flag=True, help="Run everything again, even what is stored.")
@click.option("--dry-run", is_flag=True, help="Say what would run, and run nothing.")
@click.option(
    "--report/--no-report", "with_report", default=True, help="Whether to write the report.  [default: yes]"
)
def run(
    experiment: str,
    out: Path | None,
    datasets: tuple[str, ...],
    seeds: int | None,
    jobs: int | None,
    scheduler: str | None,
    force: bool,
    dry_run: bool,
    with_report: bool,
    quiet: bool,
) -> None:
    """Scan, match, score and report: run a PRESET or an experiment described by a TOML file.

    Results that are stored in the folder already are used again, so the same command goes on after an
    interruption. Ends with the leaderboard and the path of the report.
    """
    from reports.cli.output_paths import check_output_folder

    settings = load_experiment(experiment, datasets, seeds)
    folder = check_output_folder(out or Path("results") / settings.name)
    if dry_run:
        _preview(settings, folder)
        return
    store = _sweep(settings, folder, quiet, jobs=jobs, scheduler=scheduler, force=force)
    _finish(store, with_report, quiet, jobs)


def load_experiment(name: str, datasets: tuple[str, ...] = (), seeds: int | None = None) -> "Experiment":
    """An experiment by name or path, with other data sets, which follow its rule of poses, and seeds."""
    from dataclasses import replace

    from evaluation.experiment.experiment import Dataset, Experiment

    experiment = Experiment.load(name)
    if seeds is not None:
        experiment = replace(experiment, seeds=tuple(range(seeds)))
    if not datasets:
        return experiment
    rule = experiment.dataset[0].poses
    poses: Any = "all" if isinstance(rule, tuple) else rule
    return replace(experiment, dataset=tuple(Dataset(name=each, poses=poses) for each in datasets))


def _sweep(settings: "Experiment", folder: Path, quiet: bool, **options: Any) -> "ResultsStore":
    from evaluation import run as run_experiment

    os.environ.setdefault("PYTHONWARNINGS", "ignore")  # of libraries in the workers
    note(quiet, f"{settings.name}: {settings.description}" if settings.description else settings.name)
    try:
        return run_experiment(settings, folder, progress=_progress(quiet), **options)
    except KeyboardInterrupt as stop:
        raise Interrupted(
            f"interrupted; results so far are in {str(folder)!r}, the same command goes on"
        ) from stop


def _progress(quiet: bool) -> "Progress":
    """A bar on a terminal, lines elsewhere, nothing if quiet."""
    from evaluation.running.progress import Bars, Silent

    if quiet:
        return Silent()
    console = remarks()
    return Bars(console=console) if console.is_terminal else Lines()


class Lines:
    """Progress of a run as lines at intervals, for logs."""

    def __init__(self, every: float = PLAIN_EVERY) -> None:
        self._every, self._spoken = every, time.monotonic()
        self._forecast: Forecast | None = None
        self._total = 0

    def begin(self, waiting: Mapping[str, int], stored: int, workers: int, dashboard: str) -> None:
        """Say how much there is to do."""
        from evaluation.running.progress import Forecast

        self._forecast, self._total = Forecast(dict(waiting), workers), sum(waiting.values())
        where = f", dashboard {dashboard}" if dashboard else ""
        note(False, f"{self._total} tasks to run, {stored} results stored, {workers} workers{where}")

    def advance(self, report: "Report") -> None:
        """Count a task; say where things are now and then, and failures at once."""
        assert self._forecast is not None
        self._forecast.advance(report)
        if not report.ok and report.kind != "blocked":
            note(False, f"failed: {report.task.label}: {report.reason}")
        if time.monotonic() - self._spoken >= self._every:
            self._spoken = time.monotonic()
            done = sum(self._forecast.done.values())
            rate, left = self._forecast.throughput, clock(self._forecast.seconds_left)
            note(False, f"{done} of {self._total} tasks, {rate:.1f} tasks/s, about {left} left")

    def end(self) -> None:
        """Nothing."""


def _preview(settings: "Experiment", folder: Path) -> None:
    from evaluation import preview

    outlook = preview(settings, folder)
    say = output().print
    if outlook.unknown:
        say(
            f"still to be made, tasks not counted: {', '.join(outlook.unknown)}",
            markup=False,
        )
    for stage, count in outlook.waiting.items():
        say(f"{stage:10} {count:6} to run", markup=False)
    say(f"{outlook.stored} results are stored already; the table would have {outlook.rows} rows")
    for label, reason in outlook.unavailable.items():
        say(f"{label}: would not run: {reason}", markup=False)
    if not any(outlook.waiting.values()) and not outlook.unknown:
        say("nothing to run: every result of this experiment is stored")


def _finish(store: "ResultsStore", with_report: bool, quiet: bool, jobs: int | None) -> None:
    """Leaderboard, report, and a failure that counts the failures."""
    from reports.tables.leaderboard import ceilings, leaderboard, plain

    table, page = plain(store.table()), None
    if with_report and len(table):
        from reports.page.freshness import PAIRS, is_made

        page = store.folder / "report" / "index.html"
        if not is_made(store, page.parent, PAIRS):
            from reports.cli.report import write_report

            page = write_report(store.folder, None, PAIRS, quiet, jobs)
    board = leaderboard(table, ceilings(store.settings))
    if len(board) and not quiet:
        from reports.tables.terminal import leaderboard_lines

        show(leaderboard_lines(board, output().width))
    if page is not None:
        note(quiet, "report:")
        output().print(str(page), markup=False, soft_wrap=True)
    failures = store.failures()
    for _, row in failures[failures["kind"] == "unavailable"].iterrows():
        note(quiet, f"{row['label']} did not run: {row['reason']}")
    failed = failures[failures["kind"] != "unavailable"]
    if len(failed):
        first = failed.iloc[0]
        where = str(store.folder / "failures.csv")
        raise Failure(
            f"{len(failed)} tasks have no result, listed in {where}; {first['label']}: {first['reason']}"
        )
