"""Command line ``medialbench``: the group of commands, each imported when it is asked for."""

import contextlib
import difflib
import io
import os
import signal
import sys
import threading
import time
from collections.abc import MutableMapping, Sequence
from importlib import import_module
from types import FrameType
from typing import Any

import click

from reports.cli.console import Failure, Interrupted, is_of_interrupt

COMMANDS = {
    "doctor": "reports.cli.doctor:doctor",
    "datasets": "reports.cli.datasets:datasets",
    "inspect": "reports.cli.inspect_file:inspect",
    "scan": "reports.cli.scan:scan",
    "match": "reports.cli.match:match",
    "symmetry": "reports.cli.symmetry:symmetry",
    "skeleton": "reports.cli.skeleton:skeleton",
    "score": "reports.cli.score:score",
    "run": "reports.cli.run:run",
    "report": "reports.cli.report:report",
    "figure": "reports.cli.figure:figure",
    "compare": "reports.cli.compare:compare",
    "merge": "reports.cli.merge:merge",
    "generate": "reports.cli.generate:generate",
}
"""Where each command is, in the order of the help page."""
DELICATE = ("importlib._bootstrap", "llvmlite.")
"""Modules in whose calls Ctrl-C is not raised."""
RETRY = 0.02
"""Seconds after which Ctrl-C is tried again where it cannot be raised at once."""
PATIENCE = 5.0
"""Seconds after which it is raised all the same."""


class Abandoned(SystemExit):
    """Leaves a command that was interrupted where no command expects it: threads may still compute."""


class Commands(click.Group):
    """Commands that are imported when they are asked for; failures are one line."""

    def list_commands(self, ctx: click.Context) -> list[str]:
        """Names in the order of work, not of the alphabet."""
        return list(COMMANDS)

    def get_command(self, ctx: click.Context, cmd_name: str) -> click.Command | None:
        """Import a command."""
        if cmd_name not in COMMANDS:
            return None
        module, _, name = COMMANDS[cmd_name].partition(":")
        command: click.Command = getattr(import_module(module), name)
        return command

    def resolve_command(
        self, ctx: click.Context, args: list[str]
    ) -> tuple[str | None, click.Command | None, list[str]]:
        """Find the command; one that does not exist is answered with the nearest that does."""
        if args and args[0] not in COMMANDS and not args[0].startswith("-"):
            close = difflib.get_close_matches(args[0], COMMANDS, n=1, cutoff=0.5)
            hint = f"did you mean {close[0]!r}?" if close else f"commands: {', '.join(COMMANDS)}"
            ctx.fail(f"no command {args[0]!r}; {hint}")
        return super().resolve_command(ctx, args)

    def main(
        self,
        args: Sequence[str] | None = None,
        prog_name: str | None = None,
        complete_var: str | None = None,
        standalone_mode: bool = True,
        **extra: Any,
    ) -> Any:
        """Run the command line and leave with its exit status."""
        if not standalone_mode:
            return super().main(args, prog_name, complete_var, False, **extra)
        try:
            status = super().main(args, "medialbench", complete_var, False, **extra)
        except click.UsageError as error:
            _print_failure(_usage(error))
            status = error.exit_code
        except click.ClickException as error:
            _print_failure(error.format_message())
            status = error.exit_code
        except (click.Abort, KeyboardInterrupt, OSError) as error:
            if isinstance(error, OSError) and not is_of_interrupt(error):
                raise
            with contextlib.suppress(OSError):  # a full disk, or a pipe that nobody reads
                _print_failure("interrupted")
            raise Abandoned(Interrupted.exit_code) from None
        sys.exit(status if isinstance(status, int) else 0)


def _print_failure(line: str) -> None:
    Failure(line).show()


def _usage(error: click.UsageError) -> str:
    path = error.ctx.command_path if error.ctx else "medialbench"
    message = error.format_message().rstrip(".")
    return f"{message} (see {path} --help)" if message.endswith("?") else f"{message}; see {path} --help"


def _settings() -> MutableMapping[str, Any]:
    return {"help_option_names": ["-h", "--help"], "max_content_width": 100}


@click.group(cls=Commands, context_settings=_settings(), invoke_without_command=True)
@click.version_option(package_name="medialbench", message="%(prog)s %(version)s")
@click.pass_context
def cli(ctx: click.Context) -> None:
    """Measure how well incomplete laser scans of a deforming shape can be matched.

    Scans shapes with a simulated laser scanner, matches the clouds with medial diffusion and its peers, and
    reports errors against the missing surface.
    """
    if ctx.invoked_subcommand is None:
        click.echo(ctx.get_help())


def main() -> None:
    """Entry point of the ``medialbench`` command."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")  # a terminal that is not UTF-8 gets a ? for what it lacks
    if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
        signal.signal(signal.SIGINT, Interrupt())
    try:
        cli.main()
    except Abandoned as left:
        for stream in (sys.stdout, sys.stderr):
            with contextlib.suppress(OSError, ValueError, AttributeError):  # closed; None if never open
                stream.flush()
        os._exit(int(left.code or 0))  # the interpreter must not be taken down under threads that compute


class Interrupt:
    """Raises KeyboardInterrupt, but not while a module is imported or machine code is loaded.

    Some packages ignore whatever is raised while they import others, and go on without these; C++ ones end
    the process. LLVM calls Python back while it loads a kernel: what is raised in such a call is printed and
    ignored, and the kernel that was not loaded is run all the same. So it is tried again a moment later, for
    no more than `PATIENCE`: a module of a user may compute for hours as it is imported.
    """

    def __init__(self) -> None:
        self._since: float | None = None

    def __call__(self, number: int, frame: FrameType | None) -> None:
        """Handle a signal."""
        now = time.monotonic()
        self._since = now if self._since is None else self._since
        if now - self._since < PATIENCE and _is_delicate(frame):
            again = threading.Timer(RETRY, _send_to_main_thread, [number])
            again.daemon = True
            again.start()
            return
        self._since = None
        raise KeyboardInterrupt


def _is_delicate(frame: FrameType | None) -> bool:
    while frame is not None:
        if str(frame.f_globals.get("__name__")).startswith(DELICATE):
            return True
        frame = frame.f_back
    return False


def _send_to_main_thread(number: int) -> None:
    main_thread = threading.main_thread().ident
    if hasattr(signal, "pthread_kill") and main_thread is not None:
        signal.pthread_kill(main_thread, number)  # ends a wait, which `raise_signal` does not
    else:
        signal.raise_signal(number)


if __name__ == "__main__":
    main()
