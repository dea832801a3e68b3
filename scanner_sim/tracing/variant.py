"""Which Mitsuba variant is sound on this machine: probed in child processes, never in this one.

A wrong libLLVM aborts the whole process, so each candidate first runs a small scan in a child. The fastest
variant that passes is used: CUDA, then LLVM, then scalar, which needs nothing. The environment variable
``MEDIALBENCH_VARIANT`` overrides the choice (``scalar_rgb``, ``llvm_ad_rgb``, ``cuda_ad_rgb``), and
``DRJIT_LIBLLVM_PATH`` the search for a libLLVM.
"""

import functools
import hashlib
import json
import logging
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from datasets_gen.cache import cache_folder
from datasets_gen.parsing import read_note
from datasets_gen.records import InputError, atomic_path

SCALAR, LLVM, CUDA = "scalar_rgb", "llvm_ad_rgb", "cuda_ad_rgb"
PREFERENCE = (CUDA, LLVM, SCALAR)
TIMEOUT = 120.0
"""Seconds after which a probe counts as failed; a cold start on a busy machine takes some 10."""

_LIBRARY_PATH = "DRJIT_LIBLLVM_PATH"
_OVERRIDE = "MEDIALBENCH_VARIANT"
_FOLDERS = (
    "/usr/lib/x86_64-linux-gnu",
    "/usr/lib/aarch64-linux-gnu",
    "/usr/lib64",
    "/usr/lib",
    "/usr/local/lib",
    "/usr/lib/llvm-*/lib",
    "/usr/lib64/llvm*/lib*",
    "/opt/homebrew/opt/llvm*/lib",
    "/usr/local/opt/llvm*/lib",
)
_log = logging.getLogger(__name__)
_set_here: set[str] = set()
"""Variants that `active` has set in this process."""


@dataclass(frozen=True)
class Probe:
    """Outcome of one probe.

    Attributes
    ----------
    variant : str
    works : bool
    reason : str
        Why not; empty if it works.
    library : str or None
        The libLLVM that was tried; None where no choice was made.
    """

    variant: str
    works: bool
    reason: str
    library: str | None = None


def llvm_libraries() -> list[str]:
    """Shared libLLVM files of this machine, newest version first, each once."""
    folders = list(_FOLDERS)
    if os.environ.get("CONDA_PREFIX"):
        folders.insert(0, os.path.join(os.environ["CONDA_PREFIX"], "lib"))
    found: dict[Path, tuple[int, ...]] = {}
    for pattern in folders:
        for folder in Path("/").glob(pattern.lstrip("/")):
            for path in [*folder.glob("libLLVM*.so*"), *folder.glob("libLLVM*.dylib")]:
                number = tuple(int(x) for x in re.findall(r"\d+", path.resolve().name))
                if re.match(r"libLLVM([-.\d]|\.so|\.dylib)", path.name):
                    found.setdefault(path.resolve(), number)
    return [str(path) for path, _ in sorted(found.items(), key=lambda item: (item[1], str(item[0])))][::-1]


def _run(variant: str, library: str | None) -> Probe:
    """Probe a variant in a child process."""
    environment = dict(os.environ)
    environment["PYTHONPATH"] = os.pathsep.join([p or os.getcwd() for p in sys.path])
    if library is not None:
        environment[_LIBRARY_PATH] = library
    command = [
        sys.executable,
        "-c",
        f"from scanner_sim.tracing import probe; probe.check_variant({variant!r})",
    ]
    try:
        done = subprocess.run(
            command, env=environment, capture_output=True, text=True, timeout=TIMEOUT, check=False
        )
    except subprocess.TimeoutExpired:
        return Probe(variant, False, f"the probe took longer than {TIMEOUT:.0f} s", library)
    except OSError as error:
        return Probe(variant, False, f"no child process could be started ({error})", library)
    if done.returncode == 0:
        return Probe(variant, True, "", library)
    return Probe(variant, False, _reason(done.returncode, done.stderr), library)


def _reason(code: int, errors: str) -> str:
    """One line on why a child failed."""
    lines = [line.strip() for line in errors.splitlines() if line.strip()]
    if code < 0:
        said = next((line for line in lines if "LLVM ERROR" in line or "error" in line.lower()), "")
        return f"the probe was killed by signal {-code}" + (f": {said}" if said else "")
    return lines[-1] if lines else f"the probe ended with status {code}"


def _cache_file(variant: str, library: str | None) -> Path:
    """Where the outcome of a probe is kept: one file per versions and library."""
    try:
        stamp = None if library is None else [library, os.path.getsize(library), os.path.getmtime(library)]
    except OSError:
        stamp = [library]
    identity = [
        variant,
        stamp,
        sys.version,
        version("mitsuba"),
        version("drjit"),
        os.environ.get(_LIBRARY_PATH),
    ]
    digest = hashlib.sha256(json.dumps(identity).encode()).hexdigest()[:20]
    return cache_folder() / f"probe-{digest}.json"


def _probed(variant: str, library: str | None) -> Probe:
    """Outcome of a probe, from the disk if it passed there before: failures are never kept."""
    path = _cache_file(variant, library)
    kept = read_note(path, variant=str, works=bool, reason=str, library=str | None)
    if kept is not None:
        return Probe(kept["variant"], kept["works"], kept["reason"], kept.get("library"))
    outcome = _run(variant, library)
    if outcome.works:
        try:
            with atomic_path(path) as temporary:
                temporary.write_text(json.dumps(asdict(outcome)))
        except InputError as error:
            _log.debug("probe not cached: %s", error)
    return outcome


@functools.cache
def probe(variant: str) -> tuple[Probe, ...]:
    """Probe a variant, LLVM with each library until one works; the last outcome decides.

    Cached for the process, and on disk where it passed.
    """
    if variant not in PREFERENCE:
        raise InputError(f"unknown Mitsuba variant {variant!r}; use one of {', '.join(PREFERENCE)}")
    if variant == CUDA and not _has_nvidia():
        return (Probe(CUDA, False, "no NVIDIA driver found"),)
    if variant != LLVM:
        return (_probed(variant, None),)
    given = os.environ.get(_LIBRARY_PATH)
    libraries = [given] if given else llvm_libraries()
    outcomes = []
    for library in libraries:
        if os.path.exists(library):
            outcomes.append(_probed(LLVM, library))
        else:
            outcomes.append(Probe(LLVM, False, f"{_LIBRARY_PATH} names no file", library))
        if outcomes[-1].works:
            break
    return tuple(outcomes) or (Probe(LLVM, False, "no libLLVM found; Debian: apt-get install libllvm19"),)


def _has_nvidia() -> bool:
    """Whether an NVIDIA driver is present, without loading it."""
    names = ("libcuda.so", "libcuda.so.1", "nvcuda.dll")
    folders = [*_FOLDERS, "/usr/lib/wsl/lib", "/usr/local/nvidia/lib64", "C:/Windows/System32"]
    folders += os.environ.get("LD_LIBRARY_PATH", "").split(os.pathsep)
    return Path("/dev/nvidiactl").exists() or any(
        Path(folder, name).exists() for folder in folders if folder for name in names
    )


@functools.cache
def choose() -> str:
    """Name of the fastest sound variant; child processes started later inherit the choice.

    Raises
    ------
    InputError
        If ``MEDIALBENCH_VARIANT`` names a variant that does not exist or does not work here.
    """
    wanted = os.environ.get(_OVERRIDE)
    for name in (wanted,) if wanted else PREFERENCE:
        if name == SCALAR or probe(name)[-1].works:  # scalar is part of every Mitsuba
            os.environ[_OVERRIDE] = name
            _log.info("Mitsuba variant %s", name)
            return name
    reason = probe(str(wanted))[-1].reason
    raise InputError(f"{_OVERRIDE}={wanted} does not work here: {reason}; unset it to choose automatically")


def variant_report() -> dict[str, Any]:
    """What works here and why the rest does not; probes everything, never raises or aborts.

    Returns
    -------
    dict
        ``chosen``: the variant in use or None; ``error``: why none; ``probes``: list of `Probe`;
        ``mitsuba``, ``drjit``: versions.
    """
    probes: list[Probe] = []
    for name in PREFERENCE:
        try:
            probes.extend(probe(name))
        except Exception as error:  # doctor reports whatever happens
            probes.append(Probe(name, False, f"{type(error).__name__}: {error}"))
    chosen, reason = None, ""
    try:
        chosen = choose()
    except Exception as error:
        reason = str(error)
    versions = {package: version(package) for package in ("mitsuba", "drjit")}
    return {"chosen": chosen, "error": reason, "probes": probes, **versions}


@functools.cache
def _limit_threads() -> None:
    """Keep Dr.Jit's thread pool to ``OMP_NUM_THREADS``, which Dask sets in its workers; once per process."""
    import drjit as dr

    wanted = os.environ.get("OMP_NUM_THREADS", "")
    if wanted.isdecimal() and 1 <= int(wanted) < dr.thread_count():
        dr.set_thread_count(int(wanted))


@contextmanager
def active(name: str | None = None) -> Iterator[Any]:
    """Mitsuba with a variant set, by default the chosen one.

    Setting a variant reloads parts of Mitsuba and is slow, so it is left set, unless the caller had set
    another one, which is put back.

    Parameters
    ----------
    name
        A variant known to work.
    """
    name = choose() if name is None else name
    if name == LLVM and _LIBRARY_PATH not in os.environ:
        library = probe(LLVM)[-1].library  # Dr.Jit reads the path at its first use, and only then
        if library is not None:
            os.environ[_LIBRARY_PATH] = library
    import mitsuba as mi

    before = mi.variant()
    if before != name:
        mi.set_variant(name)
        _set_here.add(name)
    _limit_threads()
    try:
        yield mi
    finally:
        if before not in (None, name) and before not in _set_here:
            mi.set_variant(before)
