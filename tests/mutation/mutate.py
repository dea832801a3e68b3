"""Change one operator or number of a formula after the other and see whether the tests notice.

``python -m tests.mutation.mutate`` (`make mutation`) copies the repository into ``build/mutation``, mutates
the copy, prints a table, and fails below the share that has to be killed; ``docs/mutation.md`` has results.
"""

import argparse
import os
import shutil
import subprocess
import sys
from pathlib import Path

from cosmic_ray.mutating import mutate_code
from cosmic_ray.plugins import get_operator
from cosmic_ray.work_db import WorkDB
from cosmic_ray.work_item import TestOutcome

from tests.mutation.configuration import MODULES, database

ROOT = Path(__file__).resolve().parents[2]
FOLDER = ROOT / "build" / "mutation"
LEAST = 0.9
"""Share of the mutants of every module that has to be killed."""


def copy_tree(target):
    """A copy of the files under version control, and of new ones that are not ignored."""
    shutil.rmtree(target, ignore_errors=True)
    listed = subprocess.run(
        ["git", "ls-files", "-z", "-co", "--exclude-standard"], cwd=ROOT, check=True, capture_output=True
    )
    for name in filter(None, listed.stdout.decode().split("\0")):
        if (ROOT / name).is_file():
            (target / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, target / name)


def environment(tree):
    """Kernels are run as plain Python: a mutant must not meet machine code of another one.

    Byte code goes by a hash of the source, as two mutants may have one size and one time of change.
    """
    one = {"NUMBA_NUM_THREADS": "1", "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}
    own = {"PYTHONPATH": str(tree), "NUMBA_DISABLE_JIT": "1", "PYTHONDONTWRITEBYTECODE": "1"}
    return {**os.environ, **one, **own}


def results(folder, module):
    """Mutants that were run, each with whether it was killed, and how many others there are."""
    work = WorkDB(database(folder, module), WorkDB.Mode.open)
    outcomes = dict(work.results)
    run = [
        (item.mutations[0], outcomes[item.job_id].test_outcome == TestOutcome.KILLED)
        for item in work.work_items
        if item.job_id in outcomes and outcomes[item.job_id].test_outcome is not None
    ]
    sampled = sum(outcome.output == "not in the sample" for outcome in outcomes.values())
    return sorted(run, key=lambda each: each[0].start_pos), sampled


def changed_line(source, mutation):
    """The first line that a mutant changes, as it is and as the mutant has it."""
    mutant = mutate_code(source, get_operator(mutation.operator_name)(), mutation.occurrence)
    lines = zip(source.splitlines(), mutant.splitlines(), strict=False)
    number, (old, new) = next((k, pair) for k, pair in enumerate(lines, 1) if pair[0] != pair[1])
    return f"{number}: {old.strip()}\n      -> {new.strip()}"


def report(modules):
    """Print a table and the survivors; the least share that was killed."""
    least, lines = 1.0, []
    for module in modules:
        run, left = results(FOLDER, module)
        killed = sum(dead for _, dead in run)
        least = min(least, killed / max(len(run), 1))
        lines.append(
            f"{module:52} {len(run) + left:6} {len(run):5} {killed:7} {killed / max(len(run), 1):7.1%}"
        )
        source = (FOLDER / "tree" / module).read_text(encoding="utf-8")
        lines += [f"    {changed_line(source, mutation)}" for mutation, dead in run if not dead]
    print(f"{'module':52} {'all':>6} {'run':>5} {'killed':>7}", *lines, sep="\n")  # noqa: T201
    return least


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("modules", nargs="*", help=f"of {', '.join(MODULES)}; all if none is given")
    parser.add_argument("--report", action="store_true", help="only print the results of the last run")
    arguments = parser.parse_args()
    modules = arguments.modules or list(MODULES)
    if unknown := sorted(set(modules) - set(MODULES)):
        parser.error(f"not in tests/mutation/modules.toml: {', '.join(unknown)}")
    if arguments.report:
        modules = [each for each in modules if database(FOLDER, each).exists()]
    else:
        tree = FOLDER / "tree"
        copy_tree(tree)
        hashed = ["-m", "compileall", "-q", "--invalidation-mode", "checked-hash", "."]
        subprocess.run([sys.executable, *hashed], cwd=tree, check=True)
        for module in modules:
            database(FOLDER, module).unlink(missing_ok=True)
            command = [sys.executable, "-m", "tests.mutation.session", module, str(FOLDER)]
            subprocess.run(command, cwd=tree, env=environment(tree), check=True)
    sys.exit(report(modules) < LEAST)


if __name__ == "__main__":
    main()
