"""``medialbench doctor``: what works on this machine, and what to do about the rest."""

import os
import platform
import shutil
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, version
from typing import NamedTuple

import click

from reports.cli.console import Command, Failure, result_console
from reports.cli.progress import ProgressBar

LIBRARIES = ("numpy", "scipy", "numba", "robust-laplacian", "dask", "matplotlib")
MARKS = {"ok": "[green]ok[/]     ", "off": "[yellow]without[/]", "bad": "[red]broken[/] "}


class Check(NamedTuple):
    """One line of the report: ``state`` is ok, off (works without it) or bad."""

    state: str
    name: str
    detail: str


@click.command(cls=Command, short_help="Say what works on this machine.")
def doctor(quiet: bool) -> None:
    """Say which scanner variants, devices and methods work here; fails if the scanner cannot run."""
    checks: list[Check] = []
    parts = (system, variants, devices, methods)
    with ProgressBar(len(parts), "looking around", quiet) as bar:
        for part in parts:
            bar.describe(f"looking at {part.__name__}")
            checks += part()
            bar.advance()
    console = result_console()
    for check in checks:
        console.print(f"{MARKS[check.state]}  {check.name:24}", end="")
        console.print(check.detail, markup=False, soft_wrap=True)
    broken = [check for check in checks if check.state == "bad"]
    if broken:
        raise Failure(f"{broken[0].name}: {broken[0].detail}")


def system() -> Iterator[Check]:
    """Versions, processors, memory, cache folder."""
    yield Check("ok", "medialbench", f"{_version('medialbench')}, Python {platform.python_version()}")
    yield Check("ok", "machine", f"{platform.platform()}, {os.cpu_count()} processors{_memory()}")
    yield Check("ok", "libraries", ", ".join(f"{name} {_version(name)}" for name in LIBRARIES))
    from datasets_gen.cache import cache_folder

    folder = cache_folder()
    existing = folder
    while not existing.exists() and existing != existing.parent:
        existing = existing.parent
    if os.access(existing, os.W_OK):
        free = shutil.disk_usage(existing).free / 1e9
        yield Check("ok", "cache", f"{folder}, {free:.0f} GB free")
    else:
        yield Check("off", "cache", f"{folder} cannot be written; set MEDIALBENCH_CACHE to a folder of yours")


def variants() -> Iterator[Check]:
    """Variants of Mitsuba, each probed in a child process."""
    try:
        from scanner_sim.tracing.variant import variant_report

        report = variant_report()
    except Exception as error:
        yield Check("bad", "scanner", f"{type(error).__name__}: {error}")
        return
    for probe in report["probes"]:
        detail = probe.reason or "works"
        if probe.library:
            detail += f" ({probe.library})"
        yield Check("ok" if probe.works else "off", f"Mitsuba {probe.variant}", detail)
    about = f"Mitsuba {report['mitsuba']}, Dr.Jit {report['drjit']}"
    if report["chosen"]:
        yield Check("ok", "scanner", f"uses {report['chosen']} ({about})")
    else:
        yield Check("bad", "scanner", f"{report['error']} ({about})")


def devices() -> Iterator[Check]:
    """Where the medial operator can be built."""
    from datasets_gen.records import InputError
    from medial.device.backend import CPU, DEVICES, backend

    for device in DEVICES:
        try:
            if device != CPU:
                backend(device)
        except InputError as error:
            yield Check("off", f"device {device}", str(error))
        else:
            yield Check("ok", f"device {device}", "works" if device != CPU else "works, used by default")


def methods() -> Iterator[Check]:
    """Matching methods and the packages that they lack."""
    from evaluation.methods import METHODS, missing

    for name in METHODS:
        try:
            lacking = missing(name)
        except Exception as error:
            lacking = f"{type(error).__name__}: {error}"
        yield Check("off" if lacking else "ok", f"method {name}", lacking or "installed")


def _version(package: str) -> str:
    try:
        return version(package)
    except PackageNotFoundError:
        return "missing"


def _memory() -> str:
    try:
        return f", {os.sysconf('SC_PAGE_SIZE') * os.sysconf('SC_PHYS_PAGES') / 1e9:.0f} GB of memory"
    except (ValueError, OSError, AttributeError):
        return ""
