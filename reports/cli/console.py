"""What all commands share: --quiet and --debug, failures as one line, what is printed where."""

import logging
import sys
import warnings
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, nullcontext
from typing import IO, TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from rich.console import Console

PACKAGES = ("datasets_gen", "scanner_sim", "medial", "evaluation", "reports", "medialbench")

TABLE_WIDTH = 132
"""Characters per line of tables where the output is no terminal."""


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
        with log_messages(ctx.params["quiet"]) if not debug else nullcontext():
            try:
                return super().invoke(ctx)
            except (click.ClickException, click.exceptions.Exit, click.Abort):
                raise
            except Exception as error:
                if is_of_interrupt(error):
                    raise KeyboardInterrupt from error
                if debug:
                    raise
                raise Failure(reason(error)) from error


def is_of_interrupt(error: BaseException) -> bool:
    """Whether an exception came of Ctrl-C: it turns into a SystemError where a compiled function returns."""
    earlier = error.__cause__ or error.__context__
    return earlier is not None and (isinstance(earlier, KeyboardInterrupt) or is_of_interrupt(earlier))


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


def result_console() -> "Console":
    """Standard output, for results."""
    from rich.console import Console

    console = Console(highlight=False)
    return console if console.is_terminal else Console(highlight=False, width=TABLE_WIDTH)


def print_lines(lines: Iterable[str]) -> None:
    """Print lines with rich's markup, unbroken."""
    console = result_console()
    for line in lines:
        console.print(line, soft_wrap=True, emoji=False)


def error_console() -> "Console":
    """Standard error, for progress and messages."""
    from rich.console import Console

    return Console(stderr=True, highlight=False)


@contextmanager
def log_messages(quiet: bool) -> Iterator[None]:
    """Show the project's own log messages: warnings, or errors alone when quiet; libraries keep theirs."""
    handler = _LogLines()
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


class _LogLines(logging.Handler):
    """Every record as one line on standard error; once, as several workers may say the same."""

    def __init__(self) -> None:
        super().__init__()
        self._said = set[str]()

    def emit(self, record: logging.LogRecord) -> None:
        line = f"{record.levelname.lower()}: {record.getMessage()}"
        if line not in self._said:
            self._said.add(line)
            error_console().print(line, style="yellow", markup=False, soft_wrap=True)


def say(quiet: bool, text: str) -> None:
    """Print a message on standard error unless quiet."""
    if not quiet:
        error_console().print(text, markup=False, style="dim", soft_wrap=True)
