"""``medialbench report``: tables, figures and the page of a results folder."""

from pathlib import Path

import click

from reports.cli.console import Command, result_console
from reports.cli.progress import ProgressBar
from reports.cli.results_folders import open_results


class Count(click.ParamType):
    """A number from 0 on, or "all"."""

    name = "number|all"

    def convert(self, value: str, param: click.Parameter | None, ctx: click.Context | None) -> int | None:
        """None for "all"."""
        if value == "all":
            return None
        if not str(value).isdigit():
            self.fail(f"{value!r} is neither a number nor 'all'", param, ctx)
        return int(value)


@click.command(cls=Command, short_help="Write tables, figures and a page of results.")
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), help="Folder to write to.  [default: DIR/report]"
)
@click.option(
    "-j", "--jobs", type=click.IntRange(min=1), help="Processes that draw.  [default: number of processors]"
)
@click.option("--pairs", type=Count(), default="24", show_default=True, help="Pairs of scans to draw.")
def report(folder: Path, out: Path | None, pairs: int | None, jobs: int | None, quiet: bool) -> None:
    """Write tables (md, tex, csv), figures (pdf, png) and index.html of the results in DIR."""
    open_results(folder, "report")
    result_console().print(str(write_report(folder, out, pairs, quiet, jobs)), markup=False, soft_wrap=True)


def write_report(
    folder: Path, out: Path | None, pairs: int | None, quiet: bool, jobs: int | None = None
) -> Path:
    """Build the report behind a progress bar; returns the path of its page."""
    from reports.cli.output_paths import check_output_folder

    check_output_folder(out or folder / "report")
    with ProgressBar(1, "loading libraries", quiet) as bar:
        from evaluation.running.environment import usable_processors
        from reports.page.report import build

        def show(label: str, done: int, total: int) -> None:
            bar.resize(max(total, 1))
            bar.describe(f"report: {label}")
            bar.move(done)

        return build(folder, out, pairs=pairs, jobs=jobs or usable_processors(), progress=show)
