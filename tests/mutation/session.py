"""The mutants of one module: made and noted by Cosmic Ray, judged by the module's tests.

``python -m tests.mutation.session NUMBER FOLDER`` within a copy of the repository, as `tests.mutation.mutate`
starts it, which also sets the environment.
"""

import argparse
import hashlib
import math
import signal
import sys
import time
from pathlib import Path

import cosmic_ray.plugins
from cosmic_ray.commands import init
from cosmic_ray.mutating import use_mutation
from cosmic_ray.tools.filters.operators_filter import OperatorsFilter
from cosmic_ray.work_db import WorkDB
from cosmic_ray.work_item import TestOutcome, WorkerOutcome, WorkResult

from tests.mutation.configuration import FILE, MODULES, MOST, database
from tests.mutation.forked import import_ahead, lies_below, run_tests
from tests.mutation.sites import lies_in, passed_over

SLOWEST = 10
"""A mutant's tests may take this many times as long as those of the module itself, and `GRACE` more."""
GRACE = 3.0


def skip(database, items, why):
    """Leave mutants out, with a reason that the session keeps."""
    for item in items:
        database.set_result(item.job_id, WorkResult(worker_outcome=WorkerOutcome.SKIPPED, output=why))


def choose(database, path):
    """Leave out what is no formula, and all but a random sample, always the same, of the rest."""
    OperatorsFilter().filter(database, argparse.Namespace(config=str(FILE)))
    places = passed_over(path.read_text(encoding="utf-8"))
    skip(
        database,
        [each for each in database.pending_work_items if lies_in(each.mutations[0].start_pos, places)],
        "no formula",
    )
    left = sorted(database.pending_work_items, key=lot)
    skip(database, left[MOST:], "not in the sample")


def key(item):
    """What a mutant does, the same in every session."""
    return item.mutations[0].operator_name, item.mutations[0].occurrence


def lot(item):
    """A number that decides about the sample: at random, but of each mutant by itself."""
    return hashlib.sha256(repr((*key(item), item.mutations[0].start_pos)).encode()).hexdigest()


def judge(database, path, tests, folder):
    """Run the tests on every mutant that is left; the time that they take without a change sets the limit."""
    module = ".".join(path.with_suffix("").parts)
    assert lies_below(module, Path.cwd()), "the tests would import another copy of the repository"
    output, loaded = folder / "output.txt", folder / "loaded.txt"
    for attempt in range(2):
        start = time.monotonic()
        if run_tests(tests, output, loaded=loaded) != 0:
            sys.exit(f"{path}: its tests fail without any change\n{output.read_text(encoding='utf-8')}")
        if attempt == 0:
            import_ahead(loaded.read_text(encoding="utf-8").split(), module)
    usual = time.monotonic() - start
    print(f"{path}: {len(database.pending_work_items)} mutants, {usual:.1f} s each", flush=True)  # noqa: T201
    for item in sorted(database.pending_work_items, key=key):
        (mutation,) = item.mutations
        operator = cosmic_ray.plugins.get_operator(mutation.operator_name)()
        with use_mutation(mutation.module_path, operator, mutation.occurrence):
            code = run_tests(tests, output, math.ceil(SLOWEST * usual + GRACE))
        outcome = TestOutcome.SURVIVED if code == 0 else TestOutcome.KILLED
        said = (
            "out of time" if code == -signal.SIGXCPU else output.read_text(encoding="utf-8", errors="replace")
        )
        database.set_result(
            item.job_id,
            WorkResult(worker_outcome=WorkerOutcome.NORMAL, test_outcome=outcome, output=said[-2000:]),
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("module", choices=MODULES)
    parser.add_argument("folder", type=Path)
    arguments = parser.parse_args()
    work = WorkDB(database(arguments.folder, arguments.module), WorkDB.Mode.create)
    path = Path(arguments.module)
    init([path], work, {})
    choose(work, path)
    judge(work, path, MODULES[arguments.module], arguments.folder)


if __name__ == "__main__":
    main()
