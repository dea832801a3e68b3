import numpy as np
import pytest

from datasets_gen import InputError, load
from datasets_gen.registry import outline
from tests.datasets_gen.collections.layout_files import egg, write_matlab, write_off, write_table


def same_places(collection, pose, count=50):
    """Whether random points of a pose lie on the reference where the same corners of its files are."""
    rng = np.random.default_rng(0)
    shape = collection[pose]
    ids = rng.integers(len(shape.faces), size=count)
    weights = rng.dirichlet(np.ones(3), size=count)
    expected = np.einsum("nc,ncd->nd", weights, collection.reference.vertices[shape.faces[ids]])
    return np.allclose(collection.canonical(shape, ids, weights), expected, atol=1e-9)


def test_matlab_files_with_a_gap_in_their_numbers(tmp_path):
    for number, bend in ((0, 0.0), (2, 0.1), (10, 0.2)):
        write_matlab(tmp_path / f"cat{number}.mat", *egg(bend))
    cats = load(tmp_path)
    assert (cats.subject, cats.poses, cats.reference.pose) == ("cat", ("cat0", "cat2", "cat10"), "cat0")
    assert outline(tmp_path) == {"subject": "cat", "poses": list(cats.poses), "reference": "cat0"}
    assert np.allclose(cats["cat10"].vertices, egg(0.2)[0])
    assert np.array_equal(np.sort(cats.reference.faces), np.sort(egg()[1]))
    assert not cats.placements
    assert any("162 vertices, 320 faces" in remark for remark in cats.remarks)


@pytest.mark.parametrize("base", [0, 1])
@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_text_files_count_from_0_or_1(tmp_path, base, newline):
    for number in (0, 1):
        vertices, faces = egg(0.1 * number)
        write_table(tmp_path / f"wolf{number}.vert", vertices, newline=newline)
        write_table(tmp_path / f"wolf{number}.tri", faces + base, newline=newline)
    wolves = load(tmp_path)
    assert np.array_equal(np.sort(wolves.reference.faces), np.sort(egg()[1]))
    assert same_places(wolves, "wolf1")


def test_a_base_that_cannot_be_told_is_refused(tmp_path):
    vertices, faces = egg()
    lone = np.zeros((1, 3))
    write_table(tmp_path / "wolf0.vert", np.concatenate([lone, vertices, lone]))
    write_table(tmp_path / "wolf0.tri", faces + 1)
    with pytest.raises(InputError, match=r"wolf0.tri' names vertices 1 to 162 of 164.*from 0 or 1; remove"):
        load(tmp_path)


def test_faces_in_another_order_are_those_of_the_reference(tmp_path):
    """And from another corner; vertices are the truth."""
    vertices, faces = egg(0.2)
    write_off(tmp_path / "dog0.off", *egg())
    write_off(tmp_path / "dog1.off", vertices, np.roll(faces[::-1], 1, axis=1))
    dogs = load(tmp_path)
    assert not dogs.placements
    assert np.allclose(dogs["dog1"].vertices, vertices)
    assert np.array_equal(dogs["dog1"].faces, dogs.reference.faces)


def test_a_pose_with_other_faces_lies_on_the_reference_by_its_vertices(tmp_path):
    """An edge is flipped: no point away from it moves."""
    vertices, faces = egg(0.2)
    a = faces[0]
    other = next(k for k in range(1, len(faces)) if len(set(faces[k]) & set(a[:2])) == 2)
    c, d = a[2], next(v for v in faces[other] if v not in a)
    changed = faces.copy()
    changed[0], changed[other] = (a[0], d, c), (d, a[1], c)
    write_off(tmp_path / "dog0.off", *egg())
    write_off(tmp_path / "dog1.off", vertices, changed)
    dogs = load(tmp_path)
    assert list(dogs.placements) == ["dog1"]
    corners = dogs.reference.at(dogs.placements["dog1"].face_ids, dogs.placements["dog1"].barycentrics)
    assert np.allclose(corners, egg()[0])
    assert any("other faces than 'dog0'" in remark for remark in dogs.remarks)


def test_several_classes_need_a_choice(tmp_path):
    for name in ("cat0", "cat1", "gorilla4"):
        write_off(tmp_path / f"{name}.off", *egg())
    with pytest.raises(InputError, match="several subjects: cat, gorilla; choose one with the option"):
        load(tmp_path)
    assert load(tmp_path, subject="gorilla").poses == ("gorilla4",)
    assert outline(tmp_path, subject="cat", poses=["cat1"])["poses"] == ["cat1"]
    with pytest.raises(InputError, match="no subject 'dog'; it has cat, gorilla"):
        load(tmp_path, subject="dog")


def test_open_eyes_are_filled_and_loose_pieces_left_out(tmp_path):
    vertices, faces = egg()
    rings = [np.flatnonzero((faces == k).any(axis=1)) for k in (0, 100)]
    opened = np.delete(faces, np.concatenate(rings), axis=0)
    loose = np.array([[0, 0, 9], [1, 0, 9], [0, 1, 9.0]])
    for number in (0, 1):
        corners = np.concatenate([vertices, loose])
        write_matlab(tmp_path / f"gorilla{number}.mat", corners, np.concatenate([opened, [[162, 163, 164]]]))
    apes = load(tmp_path)
    assert len(apes.reference.vertices) == 160  # two hubs of the eyes and the loose triangle are gone
    assert sum("2 holes" in r and "filled" in r for r in apes.remarks) == 1
    assert any("2 pieces: the largest is kept" in remark for remark in apes.remarks)
    assert any("holes" in r and "left open" in r for r in load(tmp_path, fill=False).remarks)


def damaged_matlab(path):
    vertices, faces = egg()
    faces[7, 1] = 200
    write_matlab(path / "cat0.mat", vertices, faces)


def short_row(path):
    write_table(path / "cat0.vert", egg()[0])
    write_table(path / "cat0.tri", [*egg()[1][:4] + 1, [1, 2]])


def no_faces(path):
    write_table(path / "cat0.vert", egg()[0])


def a_word(path):
    write_table(path / "cat0.tri", egg()[1] + 1)
    (path / "cat0.vert").write_text("0 0 0\n0 zero 1\n")


def other_count(path):
    write_off(path / "cat0.off", *egg())
    write_off(path / "cat1.off", egg()[0][:3], [[0, 1, 2]])


@pytest.mark.parametrize(
    ("damage", "message"),
    [
        (damaged_matlab, r"cat0.mat': surface.TRIV names vertex 201, but counts from 1 to 162; export"),
        (short_row, r"cat0.tri', line 5, has 2 columns, not 3; export"),
        (no_faces, r"has no cat0.tri beside it, which has its faces; add it"),
        (a_word, r"cat0.vert', line 2: '0 zero 1' are no 3 numbers; correct"),
        (other_count, r"cat1.off' has 3 vertices, 'cat0.off' 162; .* replace"),
    ],
)
def test_damaged_files_are_refused(tmp_path, damage, message):
    damage(tmp_path)
    with pytest.raises(InputError, match=message) as caught:
        load(tmp_path)
    assert "\n" not in str(caught.value)


def test_a_written_folder_stays_a_folder_of_poses(tmp_path):
    from datasets_gen import write_collection

    write_matlab(tmp_path / "cat0.mat", *egg())
    write_collection(load(tmp_path), tmp_path / "out")
    assert load(tmp_path / "out").subject == "cat"
