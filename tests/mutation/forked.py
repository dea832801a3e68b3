"""Tests of one mutant in a process of their own that finds NumPy, SciPy and pytest imported already.

Importing them takes longer than the tests. A fork has what its parent imported: libraries, and the packages
that cannot depend on the mutated module. The module, all that may import it, and the tests are imported anew.
"""

import gc
import importlib
import importlib.util
import multiprocessing
import os
import resource
import sys
from contextlib import suppress
from pathlib import Path

import pytest

from tests.test_architecture import FACE, ORDER

OPTIONS = ["-x", "-q", "--tb=line", "--assert=plain", "-o", "addopts="]
LEFT_OUT = ["cacheprovider", "unraisableexception", "threadexception", "faulthandler", "junitxml", "logging"]
"""The second and third collect garbage, which takes longer than most tests."""
HYPOTHESIS = ["-p", "_hypothesis_pytestplugin", "--hypothesis-seed=0"]
"""The only plugin that is loaded, without any chance."""


def run_tests(tests, output, seconds=None, loaded=None):
    """Run tests in a fork.

    Parameters
    ----------
    tests : list of str
        Arguments of pytest.
    output : Path
        Takes what it prints.
    seconds : int, optional
        Most processor time. The time on the clock says nothing where other programs run.
    loaded : Path, optional
        Takes the names of the modules that were imported.

    Returns
    -------
    int
        Exit code of pytest; negative for a signal, which is SIGXCPU's if the time was over.
    """
    fork = multiprocessing.get_context("fork").Process(target=_tests, args=(tests, output, seconds, loaded))
    fork.start()
    fork.join()
    return fork.exitcode


def _tests(tests, output, seconds, loaded):
    if seconds is not None:
        resource.setrlimit(resource.RLIMIT_CPU, (seconds, seconds + 1))
    with output.open("w") as file:
        os.dup2(file.fileno(), 1)
        os.dup2(file.fileno(), 2)
    os.environ["PYTEST_DISABLE_PLUGIN_AUTOLOAD"] = "1"
    gc.disable()
    without = [option for name in LEFT_OUT for option in ("-p", f"no:{name}")]
    code = pytest.main([*OPTIONS, *without, *HYPOTHESIS, *tests])
    if loaded is not None:
        loaded.write_text("\n".join(sorted(sys.modules)), encoding="utf-8")
    sys.stdout.flush()
    os._exit(code)


def import_ahead(names, module):
    """Import what the tests of a module need and what cannot depend on it.

    Parameters
    ----------
    names : list of str
        Modules that the tests imported.
    module : str
        The one that is mutated.
    """
    package = module.split(".")[0]
    depend = {*ORDER[ORDER.index(package) :], FACE, "tests", "conftest", "__main__"}
    for name in names:
        if name.split(".")[0] not in depend and name not in sys.modules:
            with suppress(Exception):
                importlib.import_module(name)
    gc.freeze()
    assert not any(name.split(".")[0] == package for name in sys.modules)


def lies_below(module, root):
    """Whether a module would be imported from below a folder; nothing is executed."""
    found = importlib.util.find_spec(module.split(".")[0])
    return Path(found.origin).is_relative_to(root)
