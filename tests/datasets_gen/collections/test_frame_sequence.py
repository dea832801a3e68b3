"""Frames of a capture: loaded, shown, stored and matched, but never scored."""

import numpy as np
import pytest
import trimesh

from datasets_gen import Collection, InputError, load
from datasets_gen.collections.frame_sequence import mesh_counts
from datasets_gen.collections.layouts import layout_of
from datasets_gen.registry import outline
from tests.datasets_gen.collections.layout_files import egg


def frames(folder, kind="obj", names=("frame_2", "frame_10", "frame_11")):
    """Spheres of 42, 162 and 642 vertices, the last with a stray piece."""
    folder.mkdir(exist_ok=True)
    for k, name in enumerate(names):
        mesh = trimesh.creation.icosphere(subdivisions=k + 1)
        if k == 2:
            speck = trimesh.creation.box(extents=[0.1] * 3).apply_translation([3, 0, 0])
            mesh = trimesh.util.concatenate([mesh, speck])
        mesh.export(folder / f"{name}.{kind}")
    return folder


@pytest.mark.parametrize("kind", ["obj", "ply", "off"])
def test_numbered_meshes_with_faces_of_their_own_are_frames_without_truth(tmp_path, kind):
    folder = frames(tmp_path / "jump", kind)
    assert layout_of(folder).name == "frames of a capture"
    assert outline(folder) == {
        "subject": "jump",
        "poses": ["frame_2", "frame_10", "frame_11"],
        "reference": "frame_2",
        "truth": False,
    }
    found = load(folder)
    assert [len(shape.vertices) for shape in found] == [42, 162, 650]
    assert not found.truth
    assert found.mirror is None
    told = "\n".join(found.remarks)
    for words in ("jump/frame_11: closed, 2 pieces", "no ground truth"):
        assert words in told
    shape = found["frame_10"]
    with pytest.raises(InputError, match=r"'jump' has no ground truth.*medialbench match"):
        found.on_reference(shape, np.zeros(1, np.int32), np.ones((1, 3)) / 3)


def test_frames_are_chosen_and_stored(tmp_path):
    found = load(frames(tmp_path / "jump"), poses=["frame_11"], reference="frame_10", units="mm")
    assert found.poses == ("frame_11",)
    assert found.reference.pose == "frame_10"
    found.save(tmp_path / "jump.npz")
    again = Collection.load(tmp_path / "jump.npz")
    assert not again.truth
    assert again.remarks == found.remarks
    assert again.reference.units == "mm"
    for pose in ("frame_11",):
        assert np.array_equal(again[pose].vertices, found[pose].vertices)
        assert np.array_equal(again[pose].faces, found[pose].faces)
    assert np.array_equal(again.reference.faces, found.reference.faces)


@pytest.mark.parametrize(
    "names",
    [("rest", "frame_10", "frame_11"), ("jump_1", "walk_2", "walk_3")],
    ids=["one without a number", "two names"],
)
def test_other_folders_stay_poses_and_are_refused(tmp_path, names):
    folder = frames(tmp_path / "mixed", names=names)
    assert layout_of(folder).name == "folder of poses"
    with pytest.raises(InputError, match="poses must share them"):
        load(folder)


def test_numbered_poses_that_share_their_faces_keep_their_truth(tmp_path):
    vertices, faces = egg()
    for k in range(3):
        trimesh.Trimesh(vertices * (1 + k), faces, process=False).export(tmp_path / f"frame_{k}.ply")
    assert load(tmp_path).truth


def test_counts_are_read_at_a_glance(tmp_path):
    assert mesh_counts(tmp_path / "none.ply") is None
    off = tmp_path / "a.off"
    off.write_text("OFF # of two lines\n# comment\n4 2 0\n0 0 0\n")
    assert mesh_counts(off) == (4, 2)
    obj = tmp_path / "a.obj"
    obj.write_text("v 0 0 0\nvn 0 0 1\nv\t1 0 0\nf 1 2 1\n")
    assert mesh_counts(obj) == (2, 1)
    for suffix in (".ply", ".off"):
        broken = tmp_path / f"broken{suffix}"
        broken.write_bytes(b"\xff\xfe nothing of use")
        assert mesh_counts(broken) is None
