"""The result: kinds, branches, places on edges, files."""

import json

import numpy as np
import pytest
import trimesh

from datasets_gen.records import InputError, save_record
from medial.skeletons import CurveSkeleton, write_skeleton


@pytest.fixture
def letter():
    """A Y whose foot has two edges, a node by itself, and a point that belongs to none."""
    nodes = np.array([[0.0, 0, 0], [0, 1, 0], [0, 2, 0], [1, 3, 0], [-1, 3, 0], [5, 5, 5]])
    edges = np.array([[0, 1], [1, 2], [2, 3], [2, 4]])
    return CurveSkeleton(nodes, edges, np.linspace(0.1, 0.6, 6), np.array([0, 1, 1, 4, -1, 5]), "rosa")


def ring(n=5):
    turn = 2 * np.pi * np.arange(n) / n
    nodes = np.column_stack([np.cos(turn), np.sin(turn), 0 * turn])
    edges = np.column_stack([np.arange(n), (np.arange(n) + 1) % n])
    return CurveSkeleton(nodes, edges, np.ones(n), np.zeros(0, np.int64))


def test_kinds_parts_and_loops(letter):
    assert letter.kinds.tolist() == ["tip", "inner", "joint", "tip", "tip", "alone"]
    assert len(np.unique(letter.components)) == 2
    assert letter.loops == 0
    assert ring().loops == 1
    assert repr(letter) == "CurveSkeleton(rosa: 6 nodes, 3 tips, 1 joints, 2 parts)"


def test_branches(letter):
    found = {frozenset((chain[0], chain[-1])): chain.tolist() for chain in letter.branches()}
    assert found == {
        frozenset((0, 2)): [0, 1, 2],
        frozenset((2, 3)): [2, 3],
        frozenset((2, 4)): [2, 4],
    }
    (closed,) = ring().branches()
    assert closed[0] == closed[-1]
    assert len(closed) == 6


def test_places_on_edges(letter):
    places, edge, share = letter.sampled(0.3)
    a, b = letter.nodes[letter.edges[edge]].transpose(1, 0, 2)
    assert places == pytest.approx(a + share[:, None] * (b - a))
    for k in range(4):
        mine = places[edge == k]
        assert np.linalg.norm(np.diff(mine, axis=0), axis=1).max() <= 0.3 + 1e-12
        assert (mine[[0, -1]] == letter.nodes[letter.edges[k]]).all()


def test_saved_and_read_back(letter, tmp_path):
    letter.save(tmp_path / "a.npz")
    again = CurveSkeleton.load(tmp_path / "a.npz")
    for name in ("nodes", "edges", "radii", "node_of_point"):
        assert np.array_equal(getattr(again, name), getattr(letter, name))
    assert (again.method, again.reason) == ("rosa", "")


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"edges": np.array([[0, 9]])}, "edges holds 9"),
        ({"node_of_point": np.array([-2])}, "node_of_point holds -2"),
        ({"radii": np.array([0.1, np.nan, 0.1, 0.1, 0.1, 0.1])}, "radii has numbers that are NaN"),
        ({"nodes": np.zeros((5, 3))}, "radii has shape"),
    ],
    ids=["edges", "points", "radii", "nodes"],
)
def test_files_that_do_not_fit(letter, tmp_path, change, said):
    arrays = {name: getattr(letter, name) for name in ("nodes", "edges", "radii", "node_of_point")}
    save_record(tmp_path / "a.npz", "CurveSkeleton", arrays | change, {"method": "rosa", "reason": ""})
    with pytest.raises(InputError, match=said):
        CurveSkeleton.load(tmp_path / "a.npz")


def test_another_record_is_refused(tmp_path):
    save_record(tmp_path / "a.npz", "Scan", {}, {})
    with pytest.raises(InputError, match="holds 'Scan', not 'CurveSkeleton'"):
        CurveSkeleton.load(tmp_path / "a.npz")


def test_ply_is_read_by_another_program(letter, tmp_path):
    write_skeleton(tmp_path / "a.ply", letter)
    lines = (tmp_path / "a.ply").read_text().splitlines()
    assert "element vertex 6" in lines
    assert "element edge 4" in lines
    assert lines[lines.index("end_header") + 7 :] == ["0 1", "1 2", "2 3", "2 4"]
    read = trimesh.load(tmp_path / "a.ply", process=False)
    assert np.asarray(read.vertices) == pytest.approx(letter.nodes)


def test_obj_counts_from_one(letter, tmp_path):
    write_skeleton(tmp_path / "a.obj", letter)
    lines = (tmp_path / "a.obj").read_text().splitlines()
    assert lines[1:7] == [f"v {x!r} {y!r} {z!r}" for x, y, z in letter.nodes.tolist()]
    assert lines[7:] == ["l 1 2", "l 2 3", "l 3 4", "l 3 5"]


def test_json_holds_everything(letter, tmp_path):
    write_skeleton(tmp_path / "a.json", letter)
    read = json.loads((tmp_path / "a.json").read_text())
    assert read["nodes"] == letter.nodes.tolist()
    assert read["kinds"] == letter.kinds.tolist()
    assert read["node_of_point"] == [0, 1, 1, 4, -1, 5]
    assert read["components"] == letter.components.tolist()


def test_an_empty_skeleton_can_be_written(tmp_path):
    empty = CurveSkeleton.empty(3, "rosa", "it is flat")
    for suffix in (".ply", ".obj", ".json", ".npz"):
        write_skeleton(tmp_path / f"a{suffix}", empty)
    assert CurveSkeleton.load(tmp_path / "a.npz").reason == "it is flat"
    assert empty.branches() == []
    assert empty.loops == 0


def test_nothing_half_written_and_no_other_format(letter, tmp_path):
    with pytest.raises(InputError, match=r"cannot write .*a\.stl.*\.ply, \.json, \.obj, \.npz"):
        write_skeleton(tmp_path / "a.stl", letter)
    (tmp_path / "b.ply").mkdir()
    with pytest.raises(InputError, match="it is a folder"):
        write_skeleton(tmp_path / "b.ply", letter)
    assert [path.name for path in tmp_path.iterdir()] == ["b.ply"]
