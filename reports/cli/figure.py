"""``medialbench figure``: the figures of the paper, and those of a results folder."""

from pathlib import Path
from typing import TYPE_CHECKING

import click

from reports.cli.console import Command, Failure, result_console
from reports.cli.progress import ProgressBar

if TYPE_CHECKING:
    from collections.abc import Callable

ALL = "all"
OF_RESULTS = ("missing", "pck", "failures", "calibration", "runtime", "stages")
"""Figures of a results folder."""
LAST = 11
STEPS = {1: 6, 2: 4, 3: 4, 4: 2, 5: 7, 6: 43, 7: 13, 8: 11, 9: 6, 10: 8, 11: 17}
"""How often each figure tells what it does, for the bar."""


class Names(click.ParamType):
    """Names with commas between them."""

    name = "name,..."

    def convert(
        self, value: str, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[str, ...]:
        """The names, without empty ones."""
        return (
            value if isinstance(value, tuple) else tuple(filter(None, (n.strip() for n in value.split(","))))
        )


class Thresholds(click.ParamType):
    """Numbers with commas between them."""

    name = "number,..."

    def convert(
        self, value: str, param: click.Parameter | None, ctx: click.Context | None
    ) -> tuple[float, ...]:
        """The numbers."""
        try:
            return value if isinstance(value, tuple) else tuple(float(each) for each in value.split(","))
        except ValueError:
            self.fail(f"{value!r} is no list of numbers, as 0.3 or 0.1,0.5,0.9", param, ctx)


@click.command(cls=Command, short_help="Make the figures of the paper, or those of results.")
@click.argument("which", metavar="NUMBER|all|NAME")
@click.argument("results", metavar="[DIR]", required=False, type=click.Path(path_type=Path))
@click.option(
    "--dataset",
    metavar="NAME|DIR",
    help="Shapes: a built-in body or a folder of meshes.  [default: the figure's]",
)
@click.option("--poses", type=Names(), default=(), help="Poses, as walk,sit.  [default: the figure's]")
@click.option(
    "-t",
    "--threshold",
    type=Thresholds(),
    default=(),
    help="Peak threshold of the scanner, in (0, 1]; of figure 6 several.  [default: the figure's]",
)
@click.option("--points", type=int, help="Points of every cloud.  [default: the figure's]")
@click.option("--seed", default=0, show_default=True, help="Of scans, samples and matches.")
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    help="Folder to write to.  [default: figures, or DIR/figures]",
)
def figure(
    which: str,
    results: Path | None,
    dataset: str | None,
    poses: tuple[str, ...],
    threshold: tuple[float, ...],
    points: int | None,
    seed: int,
    out: Path | None,
    quiet: bool,
) -> None:
    """Make a figure of the paper (1 to 11, or all) as PDF, PNG and the CSV behind it.

    With a NAME and a results folder DIR: missing, pck, failures, calibration, runtime or stages.
    """
    from reports.cli.output_paths import check_output_folder

    if which in OF_RESULTS or results is not None:
        _check_results_call(which, results, bool(dataset or poses or threshold or points is not None))
        assert results is not None
        _of_results(which, results, check_output_folder(out or results / "figures"), quiet)
        return
    numbers = _numbers(which)
    folder = check_output_folder(out or Path("figures"))
    with ProgressBar(sum(STEPS[n] for n in numbers), "loading libraries", quiet) as bar:
        from reports.figures.figure_request import FigureRequest
        from reports.figures.paper_figures import make_figure, write_figure

        missed = []
        for number in numbers:
            start = sum(STEPS[n] for n in numbers if n < number)
            request = FigureRequest(
                number, dataset, poses, threshold, seed, points, _teller(bar, number, start)
            )
            try:
                made = make_figure(request)
            except ValueError as error:
                if len(numbers) == 1:
                    raise
                missed.append(f"figure {number}: {error}")
                continue
            for path in write_figure(number, made, folder):
                result_console().print(str(path), markup=False, soft_wrap=True)
    if missed:
        raise Failure(f"{len(numbers) - len(missed)} of {len(numbers)} figures made; " + "; ".join(missed))


def _numbers(which: str) -> list[int]:
    if which == ALL:
        return list(range(1, LAST + 1))
    if not which.isdecimal() or not 1 <= int(which) <= LAST:
        raise click.UsageError(
            f"no figure {which!r}; give a number from 1 to {LAST}, all, or one of {', '.join(OF_RESULTS)} "
            "with a results folder"
        )
    return [int(which)]


def _teller(bar: ProgressBar, number: int, start: int) -> "Callable[[str], None]":
    """What shows a step of a figure; the bar stops at the end of its share, however many steps there are."""
    done = [0]

    def tell(step: str) -> None:
        bar.describe(f"figure {number}: {step}")
        bar.move(start + min(done[0], STEPS[number]))
        done[0] += 1

    return tell


def _check_results_call(which: str, results: Path | None, chosen: bool) -> None:
    if which not in OF_RESULTS:
        raise click.UsageError(f"no figure {which!r} of results; choose one of {', '.join(OF_RESULTS)}")
    if results is None:
        raise click.UsageError(
            f"figure {which} is of results; give their folder: medialbench figure {which} DIR"
        )
    if chosen:
        raise click.UsageError("--dataset, --poses, --threshold and --points are not for figures of results")


def _of_results(which: str, results: Path, folder: Path, quiet: bool) -> None:
    """Write a figure of a results folder."""
    from reports.cli.results_folders import open_results

    store = open_results(results, f"figure {which}")
    with ProgressBar(1, f"figure {which}", quiet):
        from reports.figures.result_figures import write_result_figure

        for path in write_result_figure(which, store, folder):
            result_console().print(str(path), markup=False, soft_wrap=True)
