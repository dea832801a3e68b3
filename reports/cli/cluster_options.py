"""Options of commands that run on workers: how many, or on which cluster."""

from collections.abc import Callable
from typing import TYPE_CHECKING, Any, TypeVar

import click

if TYPE_CHECKING:
    from evaluation.running.tls import TlsFiles

F = TypeVar("F", bound=Callable[..., Any])

OPTIONS = (
    click.option(
        "-j", "--jobs", type=click.IntRange(min=1), help="Worker processes.  [default: number of processors]"
    ),
    click.option(
        "--scheduler", metavar="tls://HOST:PORT", help="Use a running Dask cluster instead of local workers."
    ),
    click.option("--tls-ca", metavar="FILE", help="Certificate (PEM) that signed those of the cluster."),
    click.option("--tls-cert", metavar="FILE", help="Certificate (PEM) of this process for the cluster."),
    click.option("--tls-key", metavar="FILE", help="Its key (PEM), unless the certificate's file holds it."),
    click.option(
        "--dashboard", is_flag=True, help="Show Dask's dashboard of local workers, to all users here."
    ),
)


def cluster_options(command: F) -> F:
    """Add the options to a command, which is given ``jobs``, ``scheduler``, ``tls_ca`` and so on."""
    for option in reversed(OPTIONS):
        command = option(command)
    return command


def tls_files(ca: str | None, cert: str | None, key: str | None, scheduler: str | None) -> "TlsFiles | None":
    """The certificates that were given; UsageError if they cannot be used as given."""
    from evaluation.running.tls import TlsFiles

    if ca is None and cert is None and key is None:
        return None
    if ca is None or cert is None or scheduler is None:
        raise click.UsageError("--scheduler, --tls-ca and --tls-cert go together (and --tls-key)")
    return TlsFiles(ca, cert, key)
