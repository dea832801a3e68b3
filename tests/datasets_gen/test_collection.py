from dataclasses import replace

import numpy as np
import pytest

from datasets_gen import Collection, InputError
from datasets_gen.records import load_record, save_record
from tests.datasets_gen.collections.test_folder import posed


@pytest.fixture
def ball():
    shapes = (posed("pose2"), posed("rest"))
    return Collection("ball", shapes, shapes[1])


def test_a_collection_is_a_sequence_of_its_poses(ball):
    assert len(ball) == 2
    assert [shape.pose for shape in ball] == list(ball.poses) == ["pose2", "rest"]
    assert ball["rest"] is ball.reference
    with pytest.raises(InputError, match=r"has no pose 'walk'; it has \['pose2', 'rest'\]"):
        ball["walk"]


def test_its_repr_is_one_line(ball):
    assert repr(ball) == "Collection('ball': pose2, rest; 162 vertices, 320 faces)"


@pytest.mark.parametrize("mirror", [None, np.arange(162)])
@pytest.mark.parametrize("inside", [True, False], ids=["reference among the poses", "reference apart"])
def test_a_file_holds_everything(ball, mirror, inside, tmp_path):
    shapes = ball.shapes if inside else ball.shapes[:1]
    renamed = replace(shapes[0], name="my own name")
    body = Collection("ball", (renamed, *shapes[1:]), ball.reference, mirror)
    body.save(tmp_path / "body.npz")
    found = Collection.load(tmp_path / "body.npz")
    assert (found.subject, found.poses) == (body.subject, body.poses)
    assert [shape.name for shape in found] == [shape.name for shape in body]
    assert found.reference.pose == "rest"
    assert found.reference.units == "m"
    assert (found.mirror is None) == (mirror is None)
    for one, other in zip((*body, body.reference), (*found, found.reference), strict=True):
        assert np.array_equal(one.vertices, other.vertices)
        assert np.array_equal(one.faces, other.faces)


def test_a_file_of_another_version_is_refused_with_one_line(ball, tmp_path):
    ball.save(tmp_path / "body.npz")
    arrays, meta = load_record(tmp_path / "body.npz", "Collection")
    del meta["stored"]
    save_record(tmp_path / "old.npz", "Collection", arrays, meta)
    with pytest.raises(InputError, match="of another version") as error:
        Collection.load(tmp_path / "old.npz")
    assert "\n" not in str(error.value)


def test_poses_share_their_faces(ball):
    other = replace(ball["pose2"], faces=ball["pose2"].faces[::-1])
    with pytest.raises(InputError, match="must share connectivity"):
        Collection("ball", (other,), ball.reference)
