"""Every stored result names what computed it."""

import platform
from importlib.metadata import version

from evaluation.experiment.tasks import Task
from evaluation.results.store import ResultsStore


def test_a_record_names_python_the_program_and_its_libraries(tmp_path):
    store = ResultsStore(tmp_path)
    store.write_record(Task("k", "score", {}, {}, "a score"), 1.0, 1.0, None, {"row": {}})
    versions = store.record("score", "k")["versions"]
    assert versions["python"] == platform.python_version()
    assert versions["medialbench"] == version("medialbench")
    assert versions["numpy"] == version("numpy")
    assert versions["scipy"] == version("scipy")
