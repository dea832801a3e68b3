"""The long run: broken files for every reader, in processes; what fails is kept, a file for each kind.

``python -m tests.fuzzing.fuzz --count 1000000`` (``make fuzz``). A process that dies or hangs leaves the file
that it read. ``--coverage`` lets atheris choose the files by what code they reach, one target at a time.
"""

import argparse
import hashlib
import math
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from random import Random

ROOT = Path(__file__).resolve().parents[2]
BATCH = 5000
"""Cases per process: one that takes memory or dies costs no more than these."""
SLOW_SHARE = 0.1
"""Cases of a slow target, relative to the others."""
PATIENCE = 4000.0
"""Seconds that a process may take."""
MEASURED = (
    *(
        "tomllib",
        "trimesh.exchange",
        "datasets_gen.meshes",
        "datasets_gen.collections",
        "datasets_gen.parsing",
    ),
    *("datasets_gen.records", "datasets_gen.record_arrays", "evaluation.experiment", "evaluation.results"),
    *("evaluation.methods.external", "reports.cli", "scanner_sim.presets", "scanner_sim.scanner_config"),
)
"""Modules in which coverage is measured: readers, and none with compiled code, which cannot be."""


def kind_of(problem: str) -> str:
    """Problems that differ in numbers and names alone are one kind."""
    return re.sub(r"0x[0-9a-f]+|[-+]?\d[\d.e+-]*|'[^']*'", "#", problem)[:160]


def run_batch(name: str, seed: int, count: int, folder: Path, found: Path) -> None:
    """Judge some cases of a target; note each kind of problem once."""
    from tests.fuzzing.judge import judged
    from tests.fuzzing.targets import TARGETS

    target, rng, known = TARGETS[name], Random(f"{name} {seed}"), set()
    target.warm(folder)
    for _ in range(count):
        data = target.case(rng)
        problem = judged(target, data, folder)
        if problem is not None and kind_of(problem) not in known:
            known.add(kind_of(problem))
            keep(found, target.name, problem, data)


def keep(found: Path, name: str, problem: str, data: bytes) -> None:
    """Keep the smallest file of a kind of problem, and a line that says what is wrong."""
    stem = hashlib.sha256(f"{name} {kind_of(problem)}".encode()).hexdigest()[:10]
    place = found / name / stem
    place.parent.mkdir(parents=True, exist_ok=True)
    if not place.exists() or len(data) < place.stat().st_size:
        place.write_bytes(data)
        place.with_suffix(".txt").write_text(problem + "\n", encoding="utf-8", errors="replace")


def run_all(names: Sequence[str], count: int, processes: int, seed: int, found: Path) -> int:
    """Spread cases over targets and processes; returns how many were judged."""
    from tests.fuzzing.targets import TARGETS

    shares = {name: SLOW_SHARE if TARGETS[name].slow else 1.0 for name in names}
    cases = {name: math.ceil(count * share / sum(shares.values())) for name, share in shares.items()}
    batches = [
        (name, seed + start // BATCH, min(BATCH, cases[name] - start))
        for start in range(0, max(cases.values()), BATCH)
        for name in names
        if start < cases[name]
    ]
    total, running, started = 0, [], time.monotonic()
    while batches or running:
        while batches and len(running) < processes:
            name, number, size = batches.pop(0)
            scratch = tempfile.TemporaryDirectory(prefix="fuzz-")
            command = [sys.executable, "-m", __spec__.name, "--batch", name, str(number), str(size)]
            command += [scratch.name, str(found)]
            process = subprocess.Popen(command, cwd=ROOT, stderr=subprocess.PIPE, text=True)
            running.append((process, name, size, scratch, time.monotonic()))
        for each in [r for r in running if r[0].poll() is not None or time.monotonic() - r[4] > PATIENCE]:
            process, name, size, scratch, _ = each
            process.kill()
            error = process.communicate()[1]
            if process.returncode != 0:
                last = Path(scratch.name) / TARGETS[name].file
                line = error.strip().splitlines()[-1:] or [""]
                problem = f"process ended with {process.returncode}: {line[0][:300]}"
                keep(found, name, problem, last.read_bytes() if last.exists() else b"")
            total += size
            running.remove(each)
            scratch.cleanup()
            print(f"{total:>9,} cases, {time.monotonic() - started:6.0f} s, {name}", flush=True)  # noqa: T201
        time.sleep(0.05)
    return total


def run_coverage(name: str, count: int, found: Path) -> None:
    """Let atheris choose the files of one target; our own changes are its mutator."""
    import atheris

    with atheris.instrument_imports(include=list(MEASURED), enable_loader_override=False):
        from tests.fuzzing.judge import judged
        from tests.fuzzing.targets import TARGETS
    target = TARGETS[name]
    with tempfile.TemporaryDirectory(prefix="fuzz-") as scratch, tempfile.TemporaryDirectory() as corpus:
        target.warm(Path(scratch))
        for number, data in enumerate(target.seeds()):
            (Path(corpus) / str(number)).write_bytes(data)

        def one(data: bytes) -> None:
            problem = judged(target, data, Path(scratch))
            if problem is not None:
                keep(found, name, problem, data)

        def change(data: bytes, size: int, seed: int) -> bytes:
            return target.mutate(Random(seed), data, target.tokens)[:size]

        options = [sys.argv[0], corpus, f"-atheris_runs={count}", "-max_len=65536", "-rss_limit_mb=0"]
        atheris.Setup(options, one, custom_mutator=change, internal_libfuzzer=True)
        atheris.Fuzz()


def main() -> None:
    """Parse the options; exit 1 if anything was found."""
    if sys.argv[1:2] == ["--batch"]:
        name, seed, count, folder, found = sys.argv[2:]
        return run_batch(name, int(seed), int(count), Path(folder), Path(found))
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--count", type=int, default=1_000_000, help="cases in all")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--target", action="append", help="default: all")
    parser.add_argument("--found", type=Path, default=Path("build/fuzz"), help="folder for files that fail")
    parser.add_argument(
        "--coverage", action="store_true", help="choose files by coverage (pip install -e '.[fuzz]')"
    )
    given = parser.parse_args()
    found = given.found.resolve()
    if given.coverage:
        (name,) = given.target or ("mesh-ply-ascii",)
        return run_coverage(name, given.count, found)
    from tests.fuzzing.targets import TARGETS

    run_all(given.target or list(TARGETS), given.count, given.processes, given.seed, found)
    problems = sorted(found.glob("*/*.txt"))
    for note in problems:
        print(f"{note.with_suffix('')}: {note.read_text(encoding='utf-8').strip()}")  # noqa: T201
    sys.exit(1 if problems else 0)


if __name__ == "__main__":
    main()
