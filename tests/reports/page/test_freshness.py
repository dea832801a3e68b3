"""A report that is up to date is not drawn again."""

import json
import shutil

import pytest

import reports
from evaluation.results.store import ResultsStore
from reports.page.freshness import RECORD, is_made
from tests.reports.conftest import write_results


@pytest.fixture(scope="module")
def built(tmp_path_factory, plain_figures_of_module):
    folder = tmp_path_factory.mktemp("results")
    write_results(folder)
    reports.build(folder, pairs=1)
    return folder


@pytest.fixture
def made(built, tmp_path):
    folder = shutil.copytree(built, tmp_path / "copy")
    return ResultsStore(folder), folder / "report"


def test_a_report_is_made_of_its_results(made):
    assert is_made(*made, 1)
    assert not is_made(*made, 2)


@pytest.mark.parametrize("name", ["run.json", "table.parquet"])
def test_other_results_ask_for_another_report(made, name):
    file = made[0].folder / name
    file.write_bytes(file.read_bytes() + b" ")
    assert not is_made(*made, 1)


def test_a_report_without_one_of_its_files_is_not_made(made):
    next((made[1] / "figures").glob("*.png")).unlink()
    assert not is_made(*made, 1)


@pytest.mark.parametrize("text", ["", "{", "[]", json.dumps({"state": "old", "files": []})])
def test_a_record_that_says_something_else_is_no_proof(made, text):
    (made[1] / RECORD).write_text(text)
    assert not is_made(*made, 1)


def test_without_a_report_there_is_none(made):
    shutil.rmtree(made[1])
    assert not is_made(*made, 1)
