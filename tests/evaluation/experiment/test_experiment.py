import itertools
import shutil
import tomllib
from dataclasses import replace

import pytest

from datasets_gen import InputError
from datasets_gen.registry import outline
from evaluation import preview
from evaluation.experiment.config_sections import ScanCondition
from evaluation.experiment.experiment import Experiment, portable
from evaluation.experiment.make_plan import make_plan, shape_tasks
from evaluation.experiment.presets import presets
from evaluation.experiment.toml_tables import to_toml
from evaluation.methods.catalogue import create
from medial.matching.registration.evidence import KINDS
from scanner_sim import ScannerConfig

SMALL = {
    "name": "small",
    "dataset": [{"name": "human", "poses": ["rest", "sit"]}],
    "scan": {"points": 500, "scanner": {"noise": 0.1}},
    "stability": {"sweep": {"threshold": [0.3, 0.8]}},
    "matching": {"sweep": {"threshold": [0.5], "views": [2, 6]}},
    "method": [{"name": "medial", "config": "paper"}],
}


def changed(**changes):
    return Experiment.from_table({**SMALL, **changes})


def test_sweeps_are_products_over_the_base_condition():
    experiment = Experiment.from_table(SMALL)
    conditions = dict(experiment.stability_conditions())
    assert [c.threshold for c in conditions.values()] == [0.3, 0.8]
    assert {c.points for c in conditions.values()} == {500}
    regimes = experiment.regimes()
    assert [(r.name, r.source.views) for r in regimes] == [
        ("threshold 0.5, views 2", 2),
        ("threshold 0.5, views 6", 6),
    ]
    assert all(r.source == r.target for r in regimes)
    assert regimes[0].source.scanner == {"noise": 0.1}


def test_one_side_and_the_scanner_can_be_swept():
    sweep = {"target.rotation": [0.0, 90.0], "scanner.noise": [0.3]}
    regimes = changed(matching={"sweep": sweep}).regimes()
    assert [(r.source.rotation, r.target.rotation) for r in regimes] == [(0, 0), (0, 90)]
    assert {r.source.scanner["noise"] for r in regimes} == {0.3}


def test_named_regimes():
    regimes = changed(matching={"regime": [{"name": "hard", "views": "opposed", "threshold": 0.9}]}).regimes()
    assert [(r.name, r.source.views, r.target.threshold) for r in regimes] == [("hard", "opposed", 0.9)]


def test_named_regimes_follow_those_of_a_sweep():
    hard = {"name": "hard", "source.views": "front:1", "target.views": "back:1"}
    regimes = changed(matching={"sweep": {"threshold": [0.5]}, "regime": [hard]}).regimes()
    assert [(r.name, r.source.views, r.target.views, r.source.threshold) for r in regimes] == [
        ("threshold 0.5", 6, 6, 0.5),
        ("hard", "front:1", "back:1", 0.3),
    ]


@pytest.mark.parametrize("name", ["opposite", "full"])
def test_opposite_sides_are_scanned_by_one_to_three_cameras(name):
    across = {"front": "back", "left": "right"}
    views = {(r.source.views, r.target.views) for r in Experiment.load(name).regimes()}
    assert {(f"{a}:{n}", f"{b}:{n}") for a, b in across.items() for n in (1, 2, 3)} <= views


def test_ablation_leaves_out_each_kind_of_evidence_and_diffusion():
    rows = [create(m.name, m.options) for m in Experiment.load("ablation").method]
    configs = [method.match_config() for method in rows if method.config is None]
    assert {*itertools.chain(*({*KINDS} - {*c.evidence} for c in configs))} == {*KINDS}
    assert all(type(c.evidence) is tuple and len(c.evidence) >= len(KINDS) - 1 for c in configs)
    assert [c.by_diffusion for c in configs].count(False) == 1


def test_wrong_evidence_is_named_with_the_kinds_there_are():
    kinds = ", ".join(map(repr, KINDS))
    with pytest.raises(InputError, match=f"evidence must be a list, each one of {kinds}, got") as error:
        create("medial", tomllib.loads('settings = { evidence = ["strain", "path"] }'))
    assert "\n" not in str(error.value)


def test_options_of_a_method_stand_beside_its_name():
    method = Experiment.from_table(SMALL).method[0]
    assert (method.label, method.options) == ("medial", {"config": "paper"})


@pytest.mark.parametrize("name", presets())
def test_presets_are_valid_and_survive_writing(name):
    experiment = Experiment.load(name)
    assert experiment.name == name
    assert Experiment.from_table(tomllib.loads(experiment.to_toml())) == experiment


@pytest.mark.parametrize("name", presets())
def test_presets_name_methods_and_scanners_that_exist(name, tmp_path):
    experiment = Experiment.load(name)
    conditions = [c for _, c in experiment.stability_conditions()]
    conditions += [c for regime in experiment.regimes() for c in (regime.source, regime.target)]
    for condition in {repr(c): c for c in conditions}.values():
        ScannerConfig.from_dict({**condition.scanner, "views": condition.views})
    smaller = replace(experiment, seeds=experiment.seeds[:1])  # others change numbers alone
    preview(smaller, tmp_path / "none")  # makes every method with its options


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"datset": []}, "unknown key 'datset'; did you mean 'dataset'"),
        ({"scan": {"tresholds": 0.1}}, r"\[scan\]: unknown key 'tresholds'; did you mean 'threshold'"),
        ({"scan": {"threshold": 0}}, r"threshold must lie in \(0, 1\], got 0"),
        ({"scan": {"threshold": 1.5}}, r"threshold must lie in \(0, 1\], got 1.5"),
        ({"scan": {"points": 0}}, "points is 0; give a whole number of at least 8"),
        ({"scan": {"rotation": float("nan")}}, "rotation must be a finite number"),
        ({"scan": {"scale": float("inf")}}, "scale must be a finite number"),
        ({"dataset": [{"name": " "}]}, "name is empty; give a data set"),
        ({"dataset": [{"name": "human", "poses": []}]}, "poses is empty"),
        ({"dataset": [{"name": "human", "poses": ["sit", "sit"]}]}, "poses has 'sit' 2 times; give it once"),
        ({"seeds": []}, "seeds is empty; give at least one"),
        ({"seeds": [0, 0]}, "seeds has 0 2 times"),
        ({"stability": {"operators": []}}, "operators is empty"),
        ({"stability": {"operators": ["heat", "heat"]}}, "operators has 'heat' 2 times"),
        ({"stability": {"times": 0}}, "times is 0"),
        ({"stability": {"sweep": {"threshold": [0.5, 0.5]}}}, "sweep.threshold has 0.5 2 times"),
        ({"matching": {"pairs": []}}, "pairs is empty"),
        ({"matching": {"pairs": [["rest", "sit"], ["rest", "sit"]]}}, "2 times"),
        ({"matching": {"regime": [{"name": "a"}, {"name": "a"}]}}, "regimes' names has 'a' 2 times"),
        ({"matching": {"regime": [{"name": " "}]}}, "a regime needs a name"),
        ({"method": [{"name": "heat", "label": ""}]}, "a method's label is empty"),
        ({"method": [{"name": "heat", "label": "a\0"}]}, r"holds '\\x00'; rename it"),
        ({"method": [{"name": "heat", "label": "a\u202eb"}]}, "holds '.*202e'; rename it"),
        ({"method": [{"name": "heat", "options": 3}]}, "options must be a table, got 3"),
        ({"timeout": float("nan")}, "timeout must be a finite number"),
        ({"scan": {"scanner": {"views": 3}}}, "views"),
        ({"matching": {"sweep": {"thresold": [1]}}}, "unknown key 'thresold'; did you mean 'threshold'"),
        ({"matching": {"sweep": {"threshold": 0.1}}}, "must be a list"),
        ({"matching": {"pairs": "every"}}, "got 'every'"),
        ({"stability": {"operators": ["medal"]}}, "unknown operator 'medal'; did you mean 'medial'"),
        ({"method": []}, "nothing to match with"),
        ({"method": [{"name": "heat"}, {"name": "heat"}]}, "two methods are called 'heat'"),
        ({"method": [{"label": "x"}]}, "needs a name"),
        ({"dataset": []}, "nothing to scan"),
        ({"dataset": {"name": "human"}}, "two brackets|must be|needs"),
        ({"seeds": 3}, "seeds must be a list, each a whole number, got 3"),
        ({"seeds": [-1]}, "each of seeds is -1"),
        ({"seeds": [0.5]}, "seeds must be a list, each a whole number"),
        ({"stability": {"pairs": "x"}}, r"\[stability\]: pairs must be a whole number, got 'x'"),
        ({"stability": {"pairs": 0}}, r"\[stability\]: pairs is 0"),
        ({"stability": {"times": 2.5}}, "times must be a whole number"),
        ({"stability": {"operators": "medial"}}, "operators must be a list, each text, got 'medial'"),
        ({"matching": {"regime": [1]}}, r"\[matching\]: regime must be a list, got \[1\]"),
        ({"matching": {"regime": [{"name": 3}]}}, "a regime needs a name"),
        ({"matching": {"pairs": True}}, "pairs must be reference"),
        ({"matching": {"sweep": {"threshold": ["a"]}}}, "threshold must be a finite number, got 'a'"),
        ({"scan": {"threshold": "a"}}, r"\[scan\]: threshold must be a finite number, got 'a'"),
        ({"scan": {"scanner": 3}}, "scanner must be a table, got 3"),
        ({"operators": {"modes": "x"}}, r"\[operators\]: modes must be a whole number"),
        ({"timeout": "x"}, "timeout must be a finite number, got 'x'"),
        ({"timeout": float("inf")}, "timeout must be a finite number"),
        ({"evaluated": 0}, "evaluated is 0"),
        ({"name": 3}, "name must be text"),
        ({"timeout": 0}, "timeout is 0.*give up to 1e.07 seconds"),
        ({"timeout": 10**9}, "timeout is 1000000000.*; give up to"),
        ({"scan": {"scale": 1e300}}, "scale is 1e.300; give one of 1e-06 to 1e.06"),
        ({"scan": {"views": "surface", "scanner": {"noise": 0}}}, "without a scanner; leave out noise"),
        ({"departures": "some"}, "departures is 'some'; give 'all', 'none'"),
        ({"departures": {"cap": False}}, "unknown departure 'cap'"),
        ({"stability": None, "matching": None}, "nothing to measure"),
    ],
)
def test_what_cannot_be_used_is_named(changes, message):
    with pytest.raises(InputError, match=message) as error:
        changed(**changes)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("changes", "message"),
    [
        ({"scan": {"scanner": {"nois": 0.1}}}, "unknown key 'nois'; did you mean 'noise'"),
        ({"matching": {"sweep": {"scanner.stripe": [3]}}}, "unknown key 'stripe'; did you mean 'stripes'"),
        ({"scan": {"views": 0}}, "views"),
        ({"operators": {"medial": {"etta": 0.5}}}, "unknown key 'etta'; did you mean 'eta'"),
        ({"operators": {"medial": {"eta": 2}}}, "eta"),
        ({"operators": {"medial": {"device": "gpu"}}}, "unknown device 'gpu'; choose one of cpu, cuda, llvm"),
        ({"method": [{"name": "medial", "settings": {"landmark": 3}}]}, "did you mean 'landmarks'"),
        ({"method": [{"name": "heat", "settings": {"departures": "none"}}]}, "at the top of the experiment"),
        ({"method": [{"name": "medial", "config": "papr"}]}, "unknown config 'papr'; did you mean 'paper'"),
        ({"method": [{"name": "cpd", "bta": 1}]}, "unknown key 'bta'; did you mean 'beta'"),
        ({"method": [{"name": "cpd", "beta": "x"}]}, "CoherentPointDrift: beta must be a finite number"),
        (
            {"method": [{"name": "medial", "settings": {"both_ways": "false"}}]},
            "both_ways must be true or false",
        ),
        (
            {"method": [{"name": "medial", "settings": {"candidates": "x"}}]},
            "candidates must be a finite number",
        ),
        ({"operators": {"medial": {"sigma_e": "x"}}}, "sigma_e must be a finite number"),
        ({"dataset": [{"name": "human", "options": {"sed": 1}}]}, "no option 'sed'"),
    ],
)
def test_what_is_passed_on_is_checked_before_anything_runs(changes, message, tmp_path):
    with pytest.raises(InputError, match=message) as error:
        preview(changed(**changes), tmp_path / "none")
    assert "\n" not in str(error.value)


def test_unknown_presets_and_files(tmp_path):
    with pytest.raises(InputError, match="unknown preset 'quik'; did you mean 'quick'"):
        Experiment.load("quik")
    with pytest.raises(InputError, match="cannot read"):
        Experiment.load(tmp_path / "none.toml")
    bad = tmp_path / "bad.toml"
    bad.write_text("name = ")
    with pytest.raises(InputError, match="not valid TOML"):
        Experiment.load(bad)


def test_folders_are_meant_from_beside_the_file(tmp_path):
    (tmp_path / "meshes").mkdir()
    file = tmp_path / "mine.toml"
    file.write_text('[[dataset]]\nname = "meshes"\n[stability]\n')
    experiment = Experiment.load(file)
    assert experiment.name == "mine"
    assert experiment.dataset[0].name == str(tmp_path / "meshes")


def test_a_condition_keeps_what_is_not_replaced():
    base = ScanCondition(threshold=0.4, scanner={"noise": 0.2, "stripes": 10})
    found = base.with_values({"scanner.noise": 0.5, "views": 3})
    assert (found.threshold, found.views, found.scanner) == (0.4, 3, {"noise": 0.5, "stripes": 10})


def test_keys_depend_on_the_device_only_where_one_is_named(small):
    """A result of another device differs in its last digits, so it is another result."""

    def keys(**operators):
        experiment = small(operators={"modes": 30, **operators})
        shapes = shape_tasks(experiment)
        about = {"subject": "s", "poses": ["a", "b"], "reference": "a"}
        plan = make_plan(experiment, shapes, dict.fromkeys(shapes, about))
        return {task.key for task in plan.tasks.values() if task.stage == "operator" and "heat" in task.label}

    assert keys()
    assert not keys() & keys(heat={"device": "llvm"})
    assert not keys(heat={"device": "cuda"}) & keys(heat={"device": "llvm"})


def test_departures_at_the_top_reach_every_operator_unless_its_section_says_otherwise(small):
    def options(**changes):
        experiment = small(**changes)
        shapes = shape_tasks(experiment)
        about = {"subject": "s", "poses": ["a", "b"], "reference": "a"}
        tasks = make_plan(experiment, shapes, dict.fromkeys(shapes, about)).tasks.values()
        return [task.spec["options"] for task in tasks if task.stage == "operator"]

    count = len(options())
    assert count > 2
    assert options() == [{}] * count
    assert options(departures="none") == [{"departures": "none"}] * count
    own = {"departures": {"radius_cap": False}}
    assert own in options(departures="none", operators={"medial": own})
    assert tomllib.loads(small(departures="none").to_toml())["departures"] == "none"


def written(folder, blobs, method_file):
    """An experiment whose data set, method and correspondences lie beside its file."""
    for name in ("bodies", "found"):
        shutil.copytree(blobs, folder / name)
    (folder / "found" / "a--b.txt").write_text("0")
    shutil.copy(method_file, folder / "mine.py")
    (folder / "mine.toml").write_text(
        '[[dataset]]\nname = "bodies"\n[matching]\n[[method]]\nname = "mine.py:Nearest"\n'
        '[[method]]\nname = "external"\nfolder = "found"\n'
    )
    return Experiment.load(folder / "mine.toml")


def test_paths_are_meant_from_the_file_and_its_results_go_on_anywhere(
    tmp_path, blobs, method_file, monkeypatch
):
    experiment = written(tmp_path / "a", blobs, method_file)
    (tmp_path / "b").mkdir()
    monkeypatch.chdir(tmp_path / "b")
    method, external = experiment.method
    assert (method.name, method.label) == (f"{tmp_path / 'a' / 'mine.py'}:Nearest", "mine.py:Nearest")
    assert external.options["folder"] == str(tmp_path / "a" / "found")
    (tmp_path / "b" / "experiment.toml").write_text(experiment.to_toml())
    assert Experiment.load("experiment.toml") == experiment
    monkeypatch.chdir(tmp_path / "a")
    assert Experiment.load("mine.toml") == experiment


def test_settings_to_be_shared_name_no_folders_and_are_read_beside_the_files(tmp_path, blobs, method_file):
    one, other = (written(tmp_path / name, blobs, method_file) for name in "ab")
    assert one != other
    assert portable(one.as_dict()) == portable(other.as_dict())
    shared = tmp_path / "b" / "shared.toml"
    shared.write_text(to_toml(portable(one.as_dict())))
    assert str(tmp_path) not in shared.read_text()
    assert Experiment.load(shared) == other
    shutil.move(tmp_path / "b" / "bodies", tmp_path / "b" / "human")
    shared.write_text(shared.read_text().replace("./bodies", "./human"))
    assert Experiment.load(shared).dataset[0].name == str(tmp_path / "b" / "human")
    shutil.rmtree(tmp_path / "b" / "human")
    assert Experiment.load(shared).dataset[0].name == "./human"  # and not the built-in body


def test_paths_in_the_current_folder_are_found_too(tmp_path, blobs, method_file, monkeypatch):
    experiment = written(tmp_path / "a", blobs, method_file)
    (tmp_path / "b").mkdir()
    shutil.move(tmp_path / "a" / "mine.toml", tmp_path / "b")
    monkeypatch.chdir(tmp_path / "a")
    assert Experiment.load(tmp_path / "b" / "mine.toml") == experiment


def test_keys_do_not_depend_on_where_files_lie(tmp_path, blobs, method_file):
    plans = []
    for name in ("a", "b"):
        experiment = written(tmp_path / name, blobs, method_file)
        shapes = shape_tasks(experiment)
        about = {"bodies": outline(tmp_path / name / "bodies")}
        plans.append(make_plan(experiment, shapes, about))
    assert plans[0].tasks.keys() == plans[1].tasks.keys()
    methods = [task.spec["method"] for task in plans[0].tasks.values() if task.stage == "map"]
    assert set(methods) == {f"{tmp_path / 'a' / 'mine.py'}:Nearest", "external"}
    (tmp_path / "b" / "mine.py").write_text(method_file.read_text() + "\nx = 1\n")
    (tmp_path / "b" / "found" / "a--b.txt").write_text("1")
    experiment = Experiment.load(tmp_path / "b" / "mine.toml")
    edited = make_plan(experiment, shape_tasks(experiment), {"bodies": outline(tmp_path / "b" / "bodies")})
    kept = plans[0].tasks.keys() & edited.tasks.keys()
    assert not any(plans[0].tasks[key].stage in ("map", "score") for key in kept)


def test_scores_of_eq18_know_the_scale_of_their_cloud(tmp_path, blobs):
    table = {
        "name": "x",
        "dataset": [{"name": str(blobs), "poses": 1}],
        "stability": {"operators": ["heat"], "sweep": {"scale": [1.0, 1000.0]}},
    }
    experiment = Experiment.from_table(table)
    plan = make_plan(experiment, shape_tasks(experiment), {"blob": outline(blobs)})
    scans = {row.columns["regime"]: plan.tasks[row.score].spec["scale"] for row in plan.rows}
    assert scans == {"reference": 1.0, "scale 1.0": 1.0, "scale 1000.0": 1000.0}
