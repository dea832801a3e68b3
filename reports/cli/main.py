"""Command line ``medialbench``: the one place that sees all packages.

Commands live in `reports.cli`, one module each, and import what is heavy only when they run.
"""

import sys
from collections.abc import MutableMapping, Sequence
from importlib import import_module
from typing import Any

import click

from reports.cli.console import Failure, Interrupted

COMMANDS = {
    "doctor": "reports.cli.doctor:doctor",
    "datasets": "reports.cli.datasets:datasets",
    "scan": "reports.cli.scan:scan",
    "match": "reports.cli.match:match",
    "symmetry": "reports.cli.match:symmetry",
    "run": "reports.cli.run:run",
    "report": "reports.cli.report:report",
    "compare": "reports.cli.compare:compare",
    "merge": "reports.cli.merge:merge",
}
"""Where each command is, in the order of the help page."""


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
            _tell(_usage(error))
            status = error.exit_code
        except click.ClickException as error:
            _tell(error.format_message())
            status = error.exit_code
        except (click.Abort, KeyboardInterrupt):
            _tell("interrupted")
            status = Interrupted.exit_code
        sys.exit(status if isinstance(status, int) else 0)


def _tell(line: str) -> None:
    Failure(line).show()


def _usage(error: click.UsageError) -> str:
    path = error.ctx.command_path if error.ctx else "medialbench"
    return f"{error.format_message().rstrip('.')}; see {path} --help"


def _settings() -> MutableMapping[str, Any]:
    return {"help_option_names": ["-h", "--help"], "max_content_width": 100}


@click.group(cls=Commands, context_settings=_settings(), no_args_is_help=False)
@click.version_option(package_name="medialbench", message="%(prog)s %(version)s")
def cli() -> None:
    """Measure how well incomplete laser scans of a deforming shape can be matched.

    Scans shapes with a simulated laser scanner, matches the clouds with medial diffusion and its peers, and
    reports errors against the missing surface.
    """


def main() -> None:
    """Entry point of the ``medialbench`` command."""
    cli.main()


if __name__ == "__main__":
    main()
