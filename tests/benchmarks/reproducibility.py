"""What makes two runs differ, and by how much: ``python -m tests.benchmarks.reproducibility``.

Scans a fixed set of pairs, matches them once, and again with one thing changed at a time: number of threads,
kernels of the BLAS, instructions of the processor, releases of Python and of the libraries (each ``--python
PATH`` is the Python of an environment with medialbench's dependencies), variant of the scanner, and the input
itself, turned, shuffled, scaled, moved or disturbed. Prints a table in Markdown; docs/reproducibility.md has
one. ``--only WORD`` (repeatable) keeps the rows whose name contains a word, ``--pairs`` names the pairs, and
``--folder`` keeps what was computed, so that an interrupted run goes on.
"""

import argparse
import json
import os
import signal
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import medialbench as mb
from datasets_gen import Collection
from datasets_gen.records import InputError
from evaluation.metrics.correspondence import SurfacePoints, correspondence_error
from evaluation.metrics.geodesic import SurfaceDistance
from scanner_sim import Scan
from tests.benchmarks.measuring import ROOT
from tests.benchmarks.reproducible_maps import CHANGES, POSES, REGIMES, Pair

BASE = "one thread"
KERNELS = ("Haswell", "Sandybridge", "Nehalem", "SkylakeX", "Zen")
"""Sets of BLAS kernels that are asked for; one that this processor cannot run is said to be so."""
SCANNERS = ("scalar_rgb", "llvm_ad_rgb")
PAIRS = [Pair(body, regime, seed) for seed in (0, 1) for regime in REGIMES for body in POSES]


class Case(NamedTuple):
    """One way to run the matcher."""

    name: str
    python: str = sys.executable
    environment: dict[str, str] = {}  # noqa: RUF012
    change: str = "none"
    kernel: str = ""


class Difference(NamedTuple):
    """What differs between two maps of one pair; lengths are x 100 / sqrt(area)."""

    same_bits: bool
    eigenvalues: float
    samples: float
    changed: float
    moved: float
    error: float


def threads(count: int) -> dict[str, str]:
    """Environment with which everything runs on so many threads."""
    names = ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS")
    return dict.fromkeys(names, str(count))


def plain_processor() -> dict[str, str]:
    """Environment in which NumPy, the BLAS and the kernels use what every x86-64 processor has."""
    found = np.show_config(mode="dicts")["SIMD Extensions"]["found"]
    return {"NPY_DISABLE_CPU_FEATURES": " ".join(found), "NUMBA_CPU_NAME": "x86-64", "NUMBA_CPU_FEATURES": ""}


def cases(pythons: list[str]) -> list[Case]:
    """Every way to run the matcher, the first being what the others are compared to."""
    found = [Case(BASE), Case("two threads", environment=threads(2))]
    for kernel in KERNELS:
        found.append(Case(f"BLAS kernels {kernel}", environment={"OPENBLAS_CORETYPE": kernel}, kernel=kernel))
    oldest = plain_processor() | {"OPENBLAS_CORETYPE": "Nehalem"}
    found.append(Case("no AVX, no FMA", environment=oldest, kernel="Nehalem"))
    found += [Case(f"environment {path}", python=path) for path in pythons]
    found += [Case(change, change=change) for change in CHANGES if change != "none"]
    return found


def in_child(case: Case, work: Path, *arguments: str) -> dict[str, str]:
    """Run `tests.benchmarks.reproducible_maps` as a case asks; what its last line says.

    Raises
    ------
    InputError
        If it fails; a set of kernels that this processor cannot run fails so.
    """
    here = threads(1) | {"NUMBA_CACHE_DIR": str(work / f"kernels of {case.name}".replace("/", "_"))}
    if case.python == sys.executable and "NUMBA_CPU_NAME" not in case.environment:
        del here["NUMBA_CACHE_DIR"]  # code of this environment for this processor, as it is
    environment = os.environ | here | case.environment
    command = [case.python, "-m", "tests.benchmarks.reproducible_maps", *arguments]
    done = subprocess.run(command, cwd=ROOT, env=environment, capture_output=True, text=True)
    if done.returncode == -signal.SIGILL:
        raise InputError("this processor lacks its instructions")
    if done.returncode:
        raise InputError(f"failed: {(done.stderr.strip().splitlines() or ['without a word'])[-1]}")
    about: dict[str, str] = json.loads(done.stdout.splitlines()[-1])
    if case.kernel and about["blas"] != case.kernel:
        raise InputError(f"this processor gets {about['blas']} instead")
    return about


@cache
def _body(name: str) -> tuple[Collection, SurfaceDistance]:
    body = mb.load(name)
    return body, SurfaceDistance(body.reference)


class Truth:
    """The scans of a pair, and errors of maps between them.

    Parameters
    ----------
    folder
        Where the scans are.
    pair
    """

    def __init__(self, folder: Path, pair: Pair) -> None:
        self.body, self.distance = _body(pair.body)
        self.source, self.target = (Scan.load(path) for path in pair.scans(folder))
        self.unit = 100 / np.sqrt(self.body.reference.area)

    def error(self, mapped: NDArray[np.int64]) -> float:
        """Mean geodesic error, x 100 / sqrt(area)."""
        here, there = (SurfacePoints(s.face_ids, s.barycentrics) for s in (self.source, self.target))
        found = correspondence_error(self.distance, here, there, mapped, self.body.reference.area)
        return float(100 * np.nanmean(found))

    def difference(self, before: Path, after: Path) -> Difference:
        """Compare what two runs wrote."""
        old, new = np.load(before), np.load(after)
        same = all(np.array_equal(old[name], new[name]) for name in old.files)
        values = old["eigenvalues"]
        positive = values > 1e-9 * values.max()
        far = float(np.abs(new["eigenvalues"] / np.where(positive, values, 1) - 1)[positive].max())
        pairs = zip(old["samples"], new["samples"], strict=True)
        others = float(np.mean([1 - np.isin(there, here).mean() for here, there in pairs]))
        if "map" not in old.files:
            return Difference(same, far, others, np.nan, np.nan, np.nan)
        changed = old["map"] != new["map"]
        ends = self.target.true_points
        gap = np.linalg.norm(ends[old["map"]] - ends[new["map"]], axis=1)[changed]
        moved = float(self.unit * gap.mean()) if changed.any() else 0.0
        error = self.error(new["map"]) - self.error(old["map"])
        return Difference(same, far, others, float(changed.mean()), moved, error)


def mapped(case: Case, scans: Path, out: Path, pairs: list[Pair], what: str = "map") -> dict[str, str]:
    """Match pairs (or prepare them) as a case asks, those that an earlier run has not.

    Returns
    -------
    dict
        What the child says about itself.
    """
    out.mkdir(parents=True, exist_ok=True)
    note = out / "about.json"
    missing = [str(pair) for pair in pairs if not (out / f"{pair}.npz").exists()]
    if missing or not note.exists():
        about = in_child(case, out.parents[1], what, str(scans), case.change, str(out), *missing)
        note.write_text(json.dumps(about), encoding="utf-8")
    found: dict[str, str] = json.loads(note.read_text(encoding="utf-8"))
    return found


def scanned(case: Case, work: Path, pairs: list[Pair], points: int) -> Path:
    """Scan pairs, those that an earlier run has not; the folder of the scans."""
    folder = work / "scans" / case.name
    folder.mkdir(parents=True, exist_ok=True)
    missing = [str(pair) for pair in pairs if not all(path.exists() for path in pair.scans(folder))]
    if missing:
        in_child(case, work, "scan", str(folder), str(points), *missing)
    return folder


def map_rows(
    folder: Path, work: Path, pairs: list[Pair], chosen: list[Case], what: str, say: Callable[[str], None]
) -> None:
    """One row per case and regime: easy pairs, hard pairs."""
    truths = {pair: Truth(folder, pair) for pair in pairs}
    say("| change | pairs | same bits | eigenvalues | other samples | matches changed | by | mean error |")
    say("|---|---|---|---|---|---|---|---|")
    for case in chosen:
        out = work / f"{what}s" / case.name.replace("/", "_")
        try:
            about = mapped(case, folder, out, pairs, what)
        except InputError as error:
            say(f"| {case.name} | {error} | | | | | | |")
            continue
        title = case.name
        if case.name.startswith("environment"):
            title = "Python {python}, NumPy {numpy}, SciPy {scipy}, Numba {numba}".format(**about)
        for kind, hard in (("easy", False), ("hard", True)):
            some = [pair for pair in pairs if REGIMES[pair.regime].hard == hard]
            if not some:
                continue
            if case.name == BASE and what == "map":
                errors = [truths[pair].error(np.load(out / f"{pair}.npz")["map"]) for pair in some]
                means = ", ".join(f"{error:.2f}" for error in errors)
                say(f"| {title} ({about['blas']}) | {len(some)} {kind} | | | | | | mean errors {means} |")
            elif case.name != BASE:
                found = [
                    truths[pair].difference(out.parent / BASE / f"{pair}.npz", out / f"{pair}.npz")
                    for pair in some
                ]
                say(row(title, f"{len(some)} {kind}", found))


def row(title: str, pairs: str, found: list[Difference]) -> str:
    """A line of the table: the largest difference of eigenvalues, means, and the errors' mean and largest."""
    same, far, samples, changed, moved, error = (np.array(column) for column in zip(*found, strict=True))
    start = (
        f"| {title} | {pairs} | {same.sum()} of {len(same)} | {far.max():.0e} | {100 * samples.mean():.1f} %"
    )
    if np.isnan(error).any():
        return f"{start} | | | |"
    by = moved[changed > 0].mean() if changed.any() else 0
    changes = "0" if same.all() else f"{error.mean():+.3f}, at most {np.abs(error).max():.3f}"
    return f"{start} | {100 * changed.mean():.1f} % | {by:.2f} | {changes} |"


def scanner_rows(work: Path, pairs: list[Pair], points: int, say: Callable[[str], None]) -> None:
    """Scans of one variant of Mitsuba against those of another, and the errors of maps on both."""
    say("\n| pair | points of both variants | farthest apart | mean error, scalar | LLVM |")
    say("|---|---|---|---|---|")
    folders = []
    for variant in SCANNERS:
        case = Case(variant, environment={"MEDIALBENCH_VARIANT": variant})
        try:
            folders.append(scanned(case, work, pairs, points))
            mapped(case, folders[-1], work / "maps" / variant, pairs)
        except InputError as error:
            say(f"| {variant} | {error} | | | |")
            return
    for pair in pairs:
        here, there = (Truth(folder, pair) for folder in folders)
        shared, total, gap = 0, 0, 0.0
        for one, other in ((here.source, there.source), (here.target, there.target)):
            keys = [list(map(tuple, np.column_stack([s.view_ids, s.pixels]).tolist())) for s in (one, other)]
            at = {key: k for k, key in enumerate(keys[1])}
            both = [(k, at[key]) for k, key in enumerate(keys[0]) if key in at]
            shared, total = shared + len(both), total + len(one)
            i, j = np.array(both).T
            gap = max(gap, here.unit * float(np.linalg.norm(one.points[i] - other.points[j], axis=1).max()))
        errors = [
            truth.error(np.load(work / "maps" / variant / f"{pair}.npz")["map"])
            for truth, variant in zip((here, there), SCANNERS, strict=True)
        ]
        share = f"{100 * shared / total:.2f} %"
        say(f"| {pair} | {share} | {gap:.1e} | {errors[0]:.3f} | {errors[1]:.3f} |")


def main() -> None:
    """Read the command line and print both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--points", type=int, default=3000, help="points of each scan")
    parser.add_argument("--pairs", nargs="+", type=Pair.of, default=PAIRS, metavar="BODY,REGIME,SEED")
    parser.add_argument("--python", action="append", default=[], metavar="PATH")
    parser.add_argument("--only", action="append", default=[], metavar="WORD")
    parser.add_argument("--folder", type=Path, help="keep scans and maps here, and go on from what is there")
    parser.add_argument("--prepare", action="store_true", help="operators and samples, no maps: quick")
    given = parser.parse_args()
    chosen = [case for case in cases(given.python) if _wanted(case.name, given.only)]
    with tempfile.TemporaryDirectory(prefix="reproducibility-") as temporary:
        work = given.folder or Path(temporary)
        scans = scanned(Case("scans"), work, given.pairs, given.points)
        if len(chosen) > 1:
            map_rows(scans, work, given.pairs, chosen, "prepare" if given.prepare else "map", _say)
        if not given.prepare and _wanted("scanner", given.only):
            scanner_rows(work, given.pairs, given.points, _say)


def _say(line: str) -> None:
    print(line, flush=True)  # noqa: T201


def _wanted(name: str, words: list[str]) -> bool:
    return not words or name == BASE or any(word in name for word in words)


if __name__ == "__main__":
    main()
