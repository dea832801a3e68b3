from dataclasses import replace

import numpy as np
import pytest
import trimesh

from datasets_gen import Collection, InputError, Shape
from datasets_gen.mesh_placement import MeshPlacement
from datasets_gen.meshes.nearest_faces import nearest_on_mesh
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


@pytest.mark.parametrize("count", [1, 3])
def test_a_file_whose_poses_are_too_few_or_too_many_is_refused(ball, count, tmp_path):
    ball.save(tmp_path / "body.npz")
    arrays, meta = load_record(tmp_path / "body.npz", "Collection")
    arrays["vertices"] = arrays["vertices"][[0, 1, 1][:count]]
    save_record(tmp_path / "other.npz", "Collection", arrays, meta)
    with pytest.raises(InputError, match=f"vertices of {count} poses for 2"):
        Collection.load(tmp_path / "other.npz")


def test_a_file_without_faces_is_refused(ball, tmp_path):
    ball.save(tmp_path / "body.npz")
    arrays, meta = load_record(tmp_path / "body.npz", "Collection")
    save_record(tmp_path / "other.npz", "Collection", arrays | {"faces": arrays["faces"][:0]}, meta)
    with pytest.raises(InputError, match="a pose has no faces"):
        Collection.load(tmp_path / "other.npz")


def test_poses_share_their_faces(ball):
    other = replace(ball["pose2"], faces=ball["pose2"].faces[::-1])
    with pytest.raises(InputError, match="must share connectivity"):
        Collection("ball", (other,), ball.reference)


def sphere_collection(subdivisions: int) -> tuple[Collection, np.ndarray]:
    """A fine unit sphere as the reference, and a coarser, stretched one placed on it by direction."""
    fine, coarse = (trimesh.creation.icosphere(n) for n in (4, subdivisions))
    rest = Shape(np.array(fine.vertices), np.array(fine.faces, np.int32), "ball/rest", "ball", "rest")
    stretch = np.array([1.0, 2.0, 0.5])
    part = Shape(coarse.vertices * stretch, np.array(coarse.faces, np.int32), "ball/part", "ball", "part")
    place = MeshPlacement(*nearest_on_mesh(rest.vertices, rest.faces, np.array(coarse.vertices)))
    return Collection("ball", (rest, part), rest, placements={"part": place}), stretch


def test_points_of_a_shape_with_its_own_mesh_lie_on_the_reference():
    """On a stretched sphere the right place is known: the point, unstretched, in the same direction."""
    body, stretch = sphere_collection(3)
    rng = np.random.default_rng(0)
    faces = rng.integers(len(body["part"].faces), size=200)
    weights = rng.dirichlet(np.ones(3), size=200)
    found = body.canonical(body["part"], faces, weights)
    right = body["part"].at(faces, weights) / stretch
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    assert np.linalg.norm(found - right, axis=1).max() < 0.01  # facets of both meshes


def test_a_file_holds_placements(tmp_path):
    body, _ = sphere_collection(2)
    body.save(tmp_path / "body.npz")
    found = Collection.load(tmp_path / "body.npz")
    assert found.poses == ("rest", "part")
    assert np.array_equal(found["part"].faces, body["part"].faces)
    assert np.array_equal(found["part"].vertices, body["part"].vertices)
    for name in ("face_ids", "barycentrics"):
        one, other = (getattr(each.placements["part"], name) for each in (found, body))
        assert np.array_equal(one, other)


def test_a_placement_has_an_entry_for_each_vertex():
    body, _ = sphere_collection(2)
    place = body.placements["part"]
    short = MeshPlacement(place.face_ids[1:], place.barycentrics[1:])
    with pytest.raises(InputError, match="has 162 vertices, its ground truth 161 entries"):
        replace(body, placements={"part": short})


def test_vertices_of_the_reference_place_a_shape():
    body, _ = sphere_collection(2)
    rest = body.reference
    place = MeshPlacement.of_vertices(np.array([5, 0, 161]), rest)
    assert np.array_equal(rest.at(place.face_ids, place.barycentrics), rest.vertices[[5, 0, 161]])
    with pytest.raises(InputError, match="vertex 2562 of 'ball/rest' is named, but it has 2562 vertices"):
        MeshPlacement.of_vertices(np.array([2562]), rest)
