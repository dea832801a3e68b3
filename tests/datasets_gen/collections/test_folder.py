import json
import logging
from dataclasses import replace

import numpy as np
import pytest

from datasets_gen import Collection, InputError, load, load_folder, write_collection, write_mesh
from datasets_gen.registry import outline
from tests.datasets_gen.sample_meshes import shuffled, sphere

MESH = shuffled(sphere(2))
STRETCH = {"rest": (1, 1, 1), "pose2": (1, 2, 1), "pose10": (1, 1, 3)}


def posed(pose):
    return replace(
        MESH,
        vertices=MESH.vertices * STRETCH[pose],
        name=f"ball/{pose}",
        subject="ball",
        pose=pose,
        units="m",
    )


@pytest.fixture
def folder(tmp_path):
    for pose in STRETCH:
        write_mesh(posed(pose), tmp_path / "ball" / f"{pose}.ply")
    return tmp_path / "ball"


def test_poses_share_faces_and_keep_their_order(folder):
    found = load(folder)
    assert found.subject == "ball"
    assert [s.pose for s in found.shapes] == ["pose2", "pose10", "rest"]  # natural order
    assert [s.name for s in found.shapes] == ["ball/pose2", "ball/pose10", "ball/rest"]
    assert found.reference.pose == "rest"
    assert found.reference is found["rest"]
    for shape in found.shapes:
        assert shape.vertices == pytest.approx(posed(shape.pose).vertices, abs=1e-6)
        assert np.array_equal(shape.faces, MESH.faces)
    images = found.reference.vertices[found.mirror]  # a ball is as symmetric as can be
    assert np.linalg.norm(images, axis=1) == pytest.approx(1, abs=1e-6)
    assert np.array_equal(found.mirror[found.mirror], np.arange(len(images)))


def test_formats_may_be_mixed(folder):
    (folder / "rest.ply").unlink()
    write_mesh(posed("rest"), folder / "rest.obj")
    assert np.array_equal(load(folder).reference.faces, MESH.faces)


@pytest.mark.parametrize(
    ("files", "reference"),
    [
        (("b", "a", "neutral"), "neutral"),
        (("b", "TPose", "zz"), "TPose"),
        (("000", "001"), "000"),
        (("run", "bind", "rest"), "rest"),
    ],
)
def test_reference_is_known_by_its_name(tmp_path, files, reference):
    for name in files:
        write_mesh(MESH, tmp_path / f"{name}.off")
    assert load(tmp_path).reference.pose == reference


def test_reference_may_be_chosen_else_the_first_is_taken_and_logged(tmp_path, caplog):
    for name in ("b", "a", "c"):
        write_mesh(MESH, tmp_path / f"{name}.off")
    assert load(tmp_path, reference="c").reference.pose == "c"
    with caplog.at_level(logging.WARNING):
        assert load(tmp_path).reference.pose == "a"
    assert "'a', the first by name" in caplog.text


def test_poses_are_selected_and_the_reference_stays(folder):
    found = load(folder, poses=["pose10", "pose2", "pose10"])
    assert [s.pose for s in found.shapes] == ["pose10", "pose2"]
    assert found.reference.pose == "rest"


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"reference": "nope"}, "no pose 'nope' to be the reference"),
        ({"poses": ["rest", "nope"]}, "no pose 'nope'"),
        ({"poses": "rest"}, "give a list"),
        ({"poses": []}, "give a list"),
        ({"seed": 3}, "no option 'seed'"),
        ({"repair": "false"}, "option repair must be true or false, got 'false'"),
        ({"units": 3}, "option units must be text or None, got 3"),
    ],
)
def test_wrong_options(folder, options, reason):
    with pytest.raises(InputError, match=reason):
        load(folder, **options)


def test_other_counts_and_other_faces_are_told_apart(folder):
    write_mesh(sphere(1), folder / "small.ply")
    with pytest.raises(InputError, match=r"42 vertices and 80 faces.*162 and 320"):
        load(folder)
    write_mesh(shuffled(sphere(2), seed=9), folder / "small.ply")
    with pytest.raises(InputError, match=r"small.ply' has other faces than 'rest.ply'"):
        load(folder)


def test_empty_folder_missing_folder_and_a_pose_twice(tmp_path, folder):
    (tmp_path / "empty").mkdir()
    with pytest.raises(InputError, match="no mesh files"):
        load(tmp_path / "empty")
    with pytest.raises(InputError, match="is not a folder"):
        load_folder(tmp_path / "none")
    write_mesh(MESH, folder / "rest.obj")
    with pytest.raises(InputError, match="two files for the pose"):
        load(folder)


def test_a_bad_pose_is_named(folder):
    broken = posed("pose2").vertices.copy()
    broken[7] = np.nan
    write_mesh(replace(MESH, vertices=broken), folder / "pose2.ply")
    with pytest.raises(InputError, match=r"ball/pose2.*NaN"):
        load(folder)


def test_inward_faces_are_turned_in_every_pose(folder, caplog):
    for pose in STRETCH:
        write_mesh(
            replace(posed(pose), faces=np.ascontiguousarray(MESH.faces[:, ::-1])), folder / f"{pose}.ply"
        )
    with caplog.at_level(logging.WARNING):
        found = load(folder)
    assert caplog.text.count("looked inward") == 1
    assert all(np.array_equal(s.faces, MESH.faces) for s in found.shapes)


def collection():
    shapes = tuple(posed(pose) for pose in ("pose10", "rest", "pose2"))
    return Collection("ball", shapes, shapes[1])


def test_written_collection_is_read_back_by_its_manifest(tmp_path):
    path = write_collection(collection(), tmp_path / "other_name", {"licence": "MIT", "seed": 3})
    manifest = json.loads(path.read_text())
    assert manifest["licence"] == "MIT"
    assert (manifest["vertices"], manifest["faces"], manifest["seed"]) == (162, 320, 3)
    assert manifest["made_by"].startswith("medialbench ")
    found = load(tmp_path / "other_name")
    assert found.subject == "ball"
    assert found.reference.pose == "rest"
    assert found.reference.units == "m"
    assert {s.pose for s in found.shapes} == set(STRETCH)
    for shape in found.shapes:
        assert shape.vertices == pytest.approx(posed(shape.pose).vertices, abs=1e-6)
        assert np.array_equal(shape.faces, MESH.faces)


def test_manifest_decides_over_file_names(folder):
    entries = [{"pose": "stretched", "file": "pose2.ply"}, {"pose": "home", "file": "rest.ply"}]
    text = {
        "format": "medialbench-collection-1",
        "subject": "s",
        "reference": "home",
        "poses": entries,
        "units": "mm",
    }
    (folder / "manifest.json").write_text(json.dumps(text))
    found = load(folder)
    assert [s.name for s in found.shapes] == ["s/stretched", "s/home"]
    assert (found.reference.pose, found.reference.units) == ("home", "mm")
    assert load(folder, reference="stretched", units="m").reference.name == "s/stretched"


@pytest.mark.parametrize(
    "text",
    ["{", '{"format": "medialbench-collection-1"}', '{"format": "medialbench-collection-1", "poses": 3}'],
)
def test_broken_manifest_is_refused(folder, text):
    (folder / "manifest.json").write_text(text)
    with pytest.raises(InputError, match=r"manifest\.json"):
        load(folder)


def test_foreign_manifest_is_ignored_with_a_line(folder, caplog):
    (folder / "manifest.json").write_text('{"name": "web app"}')
    with caplog.at_level(logging.WARNING):
        assert len(load(folder).shapes) == 3
    assert "ignored" in caplog.text


def test_manifest_with_a_missing_file(folder):
    write_collection(collection(), folder)
    (folder / "pose2.ply").unlink()
    with pytest.raises(InputError, match="does not exist"):
        load(folder)


def test_writing_twice_replaces_but_never_mixes(tmp_path):
    write_collection(collection(), tmp_path)
    write_collection(collection(), tmp_path)
    (tmp_path / "stranger.ply").write_text("")
    with pytest.raises(InputError, match=r"stranger.ply.*empty folder"):
        write_collection(collection(), tmp_path)


def test_writing_where_no_folder_can_be(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write"):
        write_collection(collection(), tmp_path / "file")


@pytest.mark.parametrize("there", [False, True])
def test_a_disk_that_fills_up_leaves_no_part_of_a_data_set(there, tmp_path, monkeypatch):
    from datasets_gen.collections import folder as module

    def write(shape, path):
        if shape.pose != "rest":
            raise InputError(f"cannot write {str(path)!r}: No space left on device")
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text("")

    monkeypatch.setattr(module, "write_mesh", write)
    target = tmp_path / "new"
    if there:
        target.mkdir()
        (target / "mine.txt").write_text("")
    with pytest.raises(InputError, match="No space left"):
        write_collection(collection(), target)
    assert [path.name for path in tmp_path.rglob("*")] == (["new", "mine.txt"] if there else [])


def manifest_of(folder, *entries):
    poses = [{"pose": pose, "file": file} for pose, file in entries]
    text = {"format": "medialbench-collection-1", "subject": "s", "poses": poses}
    (folder / "manifest.json").write_text(json.dumps(text))


@pytest.mark.parametrize("how", ["above", "absolute", "link"])
def test_a_manifest_reads_no_file_outside_its_folder(how, folder, tmp_path):
    outside = tmp_path / "secret.ply"
    write_mesh(MESH, outside)
    (folder / "link.ply").symlink_to(outside)
    manifest_of(folder, ("a", {"above": "../secret.ply", "absolute": str(outside), "link": "link.ply"}[how]))
    for read in (load, outline):
        with pytest.raises(InputError, match=r"file of pose 'a' .* lies outside") as error:
            read(folder)
        assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    "entry", [("a", 3), (3, "rest.ply"), ("", "rest.ply"), ("a", ""), (None, "rest.ply")]
)
def test_names_in_a_manifest_are_texts(entry, folder):
    manifest_of(folder, entry)
    with pytest.raises(InputError, match="lacks 'poses' of 'pose' and 'file'"):
        load(folder)


def test_a_pose_named_twice_in_a_manifest(folder):
    manifest_of(folder, ("a", "rest.ply"), ("a", "pose2.ply"))
    with pytest.raises(InputError, match="names a pose twice"):
        load(folder)


def test_names_of_poses_that_are_paths_stay_in_the_folder_and_are_read_back(tmp_path):
    names = ["../../../esc", "/abs", "a/b", "a=2Fb", "CON", ".hidden", "new\nline", "x" * 300]
    shapes = tuple(replace(MESH, name=f"ball/{name}", subject="ball", pose=name) for name in names)
    out = tmp_path / "deep" / "er" / "out"
    write_collection(Collection("ball", shapes, shapes[0]), out)
    files = [path for path in tmp_path.rglob("*") if path.is_file()]
    assert len(files) == len(names) + 1
    assert {path.parent for path in files} == {out}
    assert list(load(out).poses) == names


def test_poses_that_differ_in_case_alone_are_not_written(tmp_path):
    shapes = tuple(replace(MESH, pose=name) for name in ("walk", "Walk"))
    with pytest.raises(InputError, match="would be one file"):
        write_collection(Collection("ball", shapes, shapes[0]), tmp_path / "out")
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("name", ["caf\udce9", "a\u202eb"])
def test_names_that_no_table_can_hold_are_refused(folder, name):
    (folder / "pose2.ply").rename(folder / f"{name}.ply")
    for function in (load, outline, load_folder):
        with pytest.raises(InputError, match=r"the pose '.*' holds '.*rename it") as refused:
            function(folder)
        str(refused.value).encode()  # can be written anywhere


def test_names_in_a_manifest_are_checked_too(folder):
    write_collection(load(folder), folder)
    path = folder / "manifest.json"
    manifest = json.loads(path.read_text())
    path.write_text(json.dumps(manifest | {"subject": "a\ud800"}))
    for function in (load, outline):
        with pytest.raises(InputError, match=r"the subject .* holds .*no UTF-8"):
            function(folder)


@pytest.mark.parametrize("what", ["vertices", "faces"])
def test_a_manifest_of_other_meshes_is_refused(folder, what):
    write_collection(load(folder), folder)
    path = folder / "manifest.json"
    manifest = json.loads(path.read_text())
    path.write_text(json.dumps(manifest | {what: manifest[what] + 1}))
    with pytest.raises(
        InputError, match=f"says {manifest[what] + 1} {what}, the files have {manifest[what]}"
    ):
        load(folder)
