"""What all commands share: --quiet and --debug, failures as one line, progress with the time left."""

import logging
import sys
import time
import warnings
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext
from typing import IO, TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rich.console import Console
    from rich.progress import Progress

PACKAGES = ("datasets_gen", "scanner_sim", "medial", "evaluation", "reports")

WIDE = 132
"""Characters per line of tables where the output is no terminal."""

PLAIN_EVERY = 15.0
"""Seconds between progress lines where the output is no terminal."""


class Failure(click.ClickException):
    """A reason to stop, shown as one line."""

    def format_message(self) -> str:
        """The reason without line breaks."""
        return " ".join(str(self.message).split())

    def show(self, file: IO[Any] | None = None) -> None:
        """Write the line to standard error."""
        click.echo(f"medialbench: {self.format_message()}", file=file or sys.stderr)


class Interrupted(Failure):
    """Stopped from the keyboard."""

    exit_code = 130


class Command(click.Command):
    """A command with --quiet and --debug that fails with one line."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        super().__init__(*args, **kwargs)
        self.params += [
            click.Option(["-q", "--quiet"], is_flag=True, help="No progress bar and no messages."),
            click.Option(["--debug"], is_flag=True, help="Show the traceback of a failure."),
        ]

    def invoke(self, ctx: click.Context) -> Any:
        """Run; turn exceptions into one-line failures unless --debug is given."""
        debug = ctx.params.pop("debug")
        with messages(ctx.params["quiet"]) if not debug else nullcontext():
            try:
                return super().invoke(ctx)
            except (click.ClickException, click.exceptions.Exit, click.Abort):
                raise
            except Exception as error:
                if debug:
                    raise
                raise Failure(reason(error)) from error


def reason(error: Exception) -> str:
    """One line that says what went wrong and what to do."""
    from datasets_gen.records import InputError

    if isinstance(error, InputError):
        return str(error).replace("repair=True", "--repair")
    if isinstance(error, MemoryError):
        return "out of memory; use fewer points (--points) or fewer workers (--jobs)"
    if isinstance(error, OSError) and error.strerror:
        where = f"{str(error.filename)!r}: " if error.filename else ""
        return f"{where}{error.strerror}"
    return f"unexpected {type(error).__name__}: {error} (add --debug for the traceback)"


def output() -> "Console":
    """Console for results."""
    from rich.console import Console

    console = Console(highlight=False)
    return console if console.is_terminal else Console(highlight=False, width=WIDE)


def show(lines: Iterable[str]) -> None:
    """Print lines with rich's markup, unbroken."""
    console = output()
    for line in lines:
        console.print(line, soft_wrap=True)


def remarks() -> "Console":
    """Console for progress and messages, which leave standard output to results."""
    from rich.console import Console

    return Console(stderr=True, highlight=False)


@contextmanager
def messages(quiet: bool) -> Iterator[None]:
    """Show the project's own log messages: warnings, or errors alone when quiet; libraries keep theirs."""
    handler = _Lines()
    handler.addFilter(lambda record: record.name.partition(".")[0] in PACKAGES)
    root = logging.getLogger()
    level = root.level
    root.addHandler(handler)
    root.setLevel(logging.ERROR if quiet else logging.WARNING)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            yield
    finally:
        root.removeHandler(handler)
        root.setLevel(level)


class _Lines(logging.Handler):
    def emit(self, record: logging.LogRecord) -> None:
        remarks().print(
            f"{record.levelname.lower()}: {record.getMessage()}", style="yellow", markup=False, soft_wrap=True
        )


def note(quiet: bool, text: str) -> None:
    """Say something on standard error unless quiet."""
    if not quiet:
        remarks().print(text, markup=False, style="dim", soft_wrap=True)


class Bar:
    """A progress bar over weighted work; lines at intervals where there is no terminal."""

    def __init__(self, total: float, description: str, quiet: bool) -> None:
        self._total, self._done, self._quiet = total, 0.0, quiet
        self._description = description
        self._begun = self._spoken = time.monotonic()
        self._rich: Progress | None = None
        console = remarks()
        if not quiet and console.is_terminal:
            self._rich = _rich_progress(console)
            self._task = self._rich.add_task(description, total=total)

    def __enter__(self) -> "Bar":
        """Start drawing."""
        if self._rich:
            self._rich.start()
        return self

    def __exit__(self, *_: object) -> None:
        """Stop drawing and leave the terminal clean."""
        if self._rich:
            self._rich.stop()

    def describe(self, description: str) -> None:
        """Change what the bar says it is doing."""
        self._description = description
        if self._rich:
            self._rich.update(self._task, description=description)

    def resize(self, total: float) -> None:
        """Change the amount of work."""
        self._total = total
        if self._rich:
            self._rich.update(self._task, total=total)

    def move(self, done: float) -> None:
        """Say how much work is finished in all."""
        self.advance(done - self._done)

    def advance(self, amount: float = 1.0) -> None:
        """Count finished work."""
        self._done += amount
        if self._rich:
            self._rich.advance(self._task, amount)
        elif not self._quiet and time.monotonic() - self._spoken >= PLAIN_EVERY:
            self._spoken = time.monotonic()
            note(False, self._line())

    def _line(self) -> str:
        spent = self._spoken - self._begun
        left = spent * (self._total - self._done) / self._done if self._done else float("nan")
        return (
            f"{self._description}: {100 * self._done / self._total:.0f} %, "
            f"{clock(spent)} passed, about {clock(left)} left"
        )


def clock(seconds: float) -> str:
    """Minutes and seconds, ``"2:05"``; hours where needed; ``"?"`` for nan."""
    if seconds != seconds:
        return "?"
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f"{hours}:{minutes:02d}:{rest:02d}" if hours else f"{minutes}:{rest:02d}"


@contextmanager
def steps(quiet: bool, named: Sequence[tuple[str, float]]) -> Iterator[Iterator[str]]:
    """A bar over named steps with weights: ``next`` of what is yielded begins the following step.

    Parameters
    ----------
    quiet
    named
        Description and rough relative duration of each step.
    """
    with Bar(sum(weight for _, weight in named), named[0][0], quiet) as bar:

        def walk() -> Iterator[str]:
            for position, (description, _) in enumerate(named):
                if position:
                    bar.advance(named[position - 1][1])
                bar.describe(description)
                yield description

        yield walk()


def _rich_progress(console: "Console") -> "Progress":
    from rich.progress import BarColumn, Progress, TaskProgressColumn, TextColumn, TimeElapsedColumn
    from rich.progress import TimeRemainingColumn as Left

    return Progress(
        TextColumn("{task.description}"),
        BarColumn(bar_width=None),
        TaskProgressColumn(),
        TimeElapsedColumn(),
        TextColumn("left"),
        Left(elapsed_when_finished=False),
        console=console,
        transient=True,
    )
