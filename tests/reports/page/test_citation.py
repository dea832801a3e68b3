"""The page says how to cite its numbers: program, experiment, settings, seeds, method."""

import json
import re

import pytest

import reports
from evaluation.results.store import write_json
from tests.reports.conftest import write_results

ABOUT = {"experiment": "small <one>", "config_hash": "0123456789abcdef", "seeds": [0, 7]}


def _citation(folder):
    text = reports.build(folder, pairs=0).read_text(encoding="utf-8")
    return " ".join(re.search(r'<p class="cite" id="cite">(.*?)</p>', text, re.DOTALL)[1].split())


@pytest.mark.usefixtures("plain_figures")
def test_program_experiment_settings_and_seeds_are_named(tmp_path):
    store = write_results(tmp_path / "results")
    info = json.loads((store.folder / "run.json").read_text(encoding="utf-8"))
    info.pop("checksum", None)
    write_json(store.folder / "run.json", {**info, **ABOUT, "versions": {"medialbench": "9.8.7"}})
    assert _citation(store.folder) == (
        "To cite these numbers, name the program, the experiment and the method: medialbench 9.8.7, "
        "experiment small &lt;one&gt; with settings 0123456789abcdef, seeds 0, 7."
    )


@pytest.mark.usefixtures("plain_figures")
def test_results_of_earlier_versions_lack_what_they_do_not_say(tmp_path):
    store = write_results(tmp_path / "results")
    assert _citation(store.folder).endswith("the method: medialbench.")
