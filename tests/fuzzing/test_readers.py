"""Each reader with some hundred broken files, the files that once failed, and bytes of any kind."""

import logging
import os
import tempfile
import time
from pathlib import Path
from random import Random

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from datasets_gen import MESH_SUFFIXES, InputError
from evaluation.methods.external import SUFFIXES
from reports.cli.cloud_files import CLOUD_SUFFIXES
from tests.fuzzing.fuzz import kind_of, run_all
from tests.fuzzing.judge import judged
from tests.fuzzing.targets import TARGETS, Target

CORPUS = Path(__file__).parent / "corpus"
CASES = 100
FEW = 15
"""Of readers that take tens of milliseconds."""


@pytest.fixture
def prepared(tmp_path):
    """A function that gives the folder of a target."""

    def make(target):
        target.warm(tmp_path)
        return tmp_path

    return make


@pytest.mark.parametrize("name", TARGETS)
def test_sound_files_are_read(name, prepared):
    target = TARGETS[name]
    path = prepared(target) / target.file
    for data in target.seeds():
        path.write_bytes(data)
        target.check(target.read(path))


@pytest.mark.parametrize("name", TARGETS)
def test_broken_files_are_read_or_refused(name, prepared):
    target, rng = TARGETS[name], Random(name)
    folder = prepared(target)
    found = [judged(target, target.case(rng), folder) for _ in range(FEW if target.slow else CASES)]
    assert {problem for problem in found if problem} == set()


@pytest.mark.parametrize("name", TARGETS)
def test_files_that_once_failed(name, prepared):
    target = TARGETS[name]
    folder = prepared(target)
    found = {path.name: judged(target, path.read_bytes(), folder) for path in (CORPUS / name).glob("*")}
    assert {key: problem for key, problem in found.items() if problem} == {}


def test_the_corpus_is_small_and_belongs_to_targets():
    files = [path for path in CORPUS.rglob("*") if path.is_file()]
    assert {path.parent.name for path in files} <= set(TARGETS)
    assert len(files) > 10
    assert sum(path.stat().st_size for path in files) < 20_000


@pytest.mark.parametrize("name", [name for name, target in TARGETS.items() if not target.slow])
def test_bytes_of_any_kind_are_read_or_refused(name):
    target = TARGETS[name]
    with tempfile.TemporaryDirectory() as folder:
        target.warm(Path(folder))

        @settings(max_examples=15, deadline=None, derandomize=True, database=None)
        @given(st.one_of(st.binary(max_size=300), st.text(max_size=100).map(str.encode)))
        def check(data):
            assert judged(target, data, Path(folder)) is None

        check()


def test_every_kind_of_file_that_is_read_has_a_target():
    suffixes = {Path(target.file).suffix for target in TARGETS.values()}
    assert {*MESH_SUFFIXES, *CLOUD_SUFFIXES, *SUFFIXES} <= suffixes


def test_cases_are_the_same_each_time():
    for target in TARGETS.values():
        if target.mutate.__name__ == "mutated":
            assert target.case(Random(7)) == target.case(Random(7))


def _raise(error):
    raise error


def _work(_path):
    end = time.monotonic() + 20
    while time.monotonic() < end:
        pass


def _log_traceback(_path):
    try:
        _raise(KeyError("gone"))
    except KeyError:
        logging.getLogger("medial").exception("went wrong")


@pytest.mark.parametrize(
    ("read", "says"),
    [
        (lambda path: _raise(KeyError("gone")), "KeyError"),
        (lambda path: _raise(InputError("two\nlines")), "not one line"),
        (lambda path: _raise(InputError(" ")), "not one line"),
        (_work, "too long"),
        (lambda path: time.sleep(20), "too long"),
        (lambda path: np.ones(1 << 40), "MemoryError"),
        (lambda path: (path.parent.parent / "stray.txt").write_text("x"), "wrote outside"),
        (lambda path: os.mkdir(path.parent.parent / "stray"), "wrote outside"),
        (_log_traceback, "logged a traceback"),
        (lambda path: _raise(InputError("no")), None),
        (lambda path: (path.parent / "inside.txt").write_text("x"), None),
    ],
)
def test_the_judge_sees_what_is_wrong(read, says, tmp_path):
    target = Target(name="some", file="file", seeds=lambda: (b"",), read=read)
    (tmp_path / "case").mkdir()
    problem = judged(target, b"x", tmp_path / "case", 0.2)
    assert problem is None if says is None else says in problem


def test_the_judge_sees_an_unsound_object(tmp_path):
    def check(found):
        assert found == 1

    target = Target(name="some", file="file", seeds=lambda: (b"",), read=lambda path: 2, check=check)
    assert "AssertionError" in judged(target, b"x", tmp_path)


def test_problems_that_differ_in_numbers_are_one_kind():
    assert kind_of("shape (3, 4) of 'a'") == kind_of("shape (5, 1) of 'b'")
    assert kind_of("KeyError") != kind_of("ValueError")


@pytest.mark.slow
def test_the_long_run_counts_its_cases(tmp_path, capfd):
    assert run_all(["mesh-off", "cloud-xyz"], 60, 1, 0, tmp_path / "found") == 60
    assert not (tmp_path / "found").exists()
    assert "60 cases" in capfd.readouterr().out
