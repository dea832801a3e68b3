"""Data sets in the folders in which they come: keys, names in tables, and parts sampled as they are."""

import pytest

from datasets_gen import InputError, load
from datasets_gen.registry import outline
from evaluation.experiment.experiment import Experiment
from evaluation.experiment.make_plan import make_plan, shape_tasks
from evaluation.running.stages import threshold_scan
from tests.datasets_gen.collections.gltf_files import animate, turn, two_bones
from tests.datasets_gen.collections.layout_files import egg, write_off, write_table
from tests.datasets_gen.collections.test_shrec_partial import part_of, written


class Loaded:
    """Inputs of a stage: the collection, and no render."""

    def __init__(self, collection):
        self.collection = collection

    def load(self, name):
        assert name == "shape"
        return self.collection


def experiment(folder, subject="cat", **changes):
    table = {
        "name": "parts",
        "dataset": [{"name": str(folder), "options": {"subject": subject}}],
        "scan": {"views": "surface", "points": 300},
        "matching": {"pairs": "reference"},
        "method": [{"name": "medial"}],
    }
    return Experiment.from_table({**table, **changes})


def test_a_truth_in_a_subfolder_is_part_of_the_key(tmp_path):
    written(tmp_path)
    before = shape_tasks(experiment(tmp_path))
    name = f"{tmp_path.name}-cat"
    assert list(before) == [name]
    path = tmp_path / "cuts" / "cuts_cat_shape_1.baryc_gt"
    path.write_text(path.read_text().replace("1 0 0", "0 1 0", 1))
    changed = shape_tasks(experiment(tmp_path))
    assert changed[name].key != before[name].key
    path.rename(path.with_name("cuts_cat_shape_2.baryc_gt"))
    assert shape_tasks(experiment(tmp_path))[name].key not in (before[name].key, changed[name].key)


def test_files_that_no_layout_reads_are_not(tmp_path):
    written(tmp_path)
    before = shape_tasks(experiment(tmp_path))
    (tmp_path / "results").mkdir()
    (tmp_path / "results" / "table.csv").write_text("1\n")
    assert shape_tasks(experiment(tmp_path)) == before


def test_two_subjects_of_one_folder_are_two_data_sets(tmp_path):
    written(tmp_path)
    entries = [{"name": str(tmp_path), "options": {"subject": name}} for name in ("cat", "dog")]
    found = shape_tasks(experiment(tmp_path, dataset=entries))
    assert list(found) == [f"{tmp_path.name}-cat", f"{tmp_path.name}-dog"]
    assert len({task.key for task in found.values()}) == 2


def test_surfaces_are_sampled_without_a_render(tmp_path):
    written(tmp_path)
    settings = experiment(tmp_path)
    shapes = shape_tasks(settings)
    plan = make_plan(settings, shapes, {next(iter(shapes)): outline(tmp_path, subject="cat")})
    assert {task.stage for task in plan.tasks.values()} == {"shape", "scan", "operator", "map", "score"}
    assert {row.columns["views"] for row in plan.rows} == {"surface"}


def test_a_character_goes_by_its_name_and_all_its_files_are_part_of_the_key(tmp_path):
    writer, _, _ = two_bones()
    animate(writer, "bend", times=[0, 1], values=[turn(0, 0), turn(0, 60)])
    path = writer.write_gltf(tmp_path / "tube.gltf", "tube.bin")
    entries = [{"name": str(path), "options": {"frames": 2}}]
    settings = experiment(path, dataset=entries)
    before = shape_tasks(settings)
    assert list(before) == ["tube"]
    plan = make_plan(settings, before, {"tube": outline(path, frames=2)})
    assert {row.columns["target_pose"] for row in plan.rows} == {"bend-1", "bend-2"}
    data = tmp_path / "tube.bin"
    data.write_bytes(data.read_bytes()[:-1] + b"\x01")
    assert shape_tasks(settings)["tube"].key != before["tube"].key


def test_shapes_without_truth_are_refused_before_anything_runs(tmp_path):
    settings = experiment(tmp_path, dataset=[{"name": str(tmp_path)}])
    about = {"subject": "jump", "poses": ["frame_1", "frame_2"], "reference": "frame_1", "truth": False}
    shapes = shape_tasks(settings)
    with pytest.raises(InputError, match="'jump' has no ground truth"):
        make_plan(settings, shapes, {next(iter(shapes)): about})


@pytest.mark.parametrize("height", [-9.0, 0.0])
def test_what_a_part_lacks_is_measured_on_the_full_shape(tmp_path, height):
    """Of the area, whatever the size of the part's own mesh."""
    vertices, faces = egg()
    part, own, rows, _ = part_of(vertices, faces, vertices[:, 2] > height)
    write_off(tmp_path / "null" / "cat.off", vertices, faces)
    write_off(tmp_path / "cuts" / "cuts_cat_shape_1.off", 7 * part, own)
    write_table(tmp_path / "cuts" / "cuts_cat_shape_1.baryc_gt", rows)
    cats = load(tmp_path)
    inside = (vertices[faces][:, :, 2] > height).all(axis=1)
    expected = 1 - cats.reference.face_areas[inside].sum() / cats.reference.area
    spec = {"pose": "cuts-1", "points": 200, "seed": 3, "surface": True, "rotation": 20.0, "scale": 2.0}
    output = threshold_scan.compute(spec, Loaded(cats))
    assert output.info["points"] == 200
    assert output.info["missing"] == pytest.approx(expected, abs=0.03)
    full = threshold_scan.compute({**spec, "pose": "null"}, Loaded(cats))
    assert full.info["missing"] == 0.0
