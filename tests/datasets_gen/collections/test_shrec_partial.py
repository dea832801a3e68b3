import numpy as np
import pytest

from datasets_gen import InputError, load
from datasets_gen.registry import outline
from tests.datasets_gen.collections.layout_files import egg, write_off, write_table


def part_of(vertices, faces, inside):
    """The faces whose corners are all inside, their vertices, and rows of truth."""
    kept = faces[inside[faces].all(axis=1)]
    used, own = np.unique(kept, return_inverse=True)
    rows = []
    for vertex in used:
        face, corner = np.argwhere(faces == vertex)[0]
        rows.append([face + 1, *np.eye(3)[corner]])
    return vertices[used], own.reshape(-1, 3), np.array(rows), used


def written(folder, *, newline="\n"):
    """A cat with two cuts of two poses, and a dog without parts."""
    vertices, faces = egg()
    write_off(folder / "null" / "cat.off", vertices, faces, newline=newline)
    write_off(folder / "null" / "dog.off", vertices, faces)
    found = {}
    for number, height in ((1, 0.2), (10, -0.5)):
        posed, own, rows, used = part_of(egg(0.2)[0], faces, vertices[:, 2] > height)
        stem = f"cuts_cat_shape_{number}"
        write_off(folder / "cuts" / f"{stem}.off", posed, own, newline=newline)
        write_table(folder / "cuts" / f"{stem}.baryc_gt", rows, newline=newline)
        write_table(folder / "cuts" / f"{stem}.baryc_gt_sym", rows[::-1], newline=newline)
        found[f"cuts-{number}"] = used
    return found


@pytest.mark.parametrize("newline", ["\n", "\r\n"])
def test_parts_lie_on_the_full_shape(tmp_path, newline):
    used = written(tmp_path, newline=newline)
    cats = load(tmp_path, subject="cat")
    assert (cats.poses, cats.reference.pose) == (("null", "cuts-1", "cuts-10"), "null")
    assert outline(tmp_path, subject="cat") == {
        "subject": "cat", "poses": list(cats.poses), "reference": "null",
    }  # fmt: skip
    for pose, ids in used.items():
        place = cats.placements[pose]
        assert np.allclose(cats.reference.at(place.face_ids, place.barycentrics), egg()[0][ids])
        assert np.allclose(cats[pose].vertices, egg(0.2)[0][ids])
    middle = np.full((1, 3), 1 / 3)
    face = cats["cuts-1"].faces[0]
    expected = egg()[0][used["cuts-1"]][face].mean(axis=0)
    assert np.allclose(cats.canonical(cats["cuts-1"], np.array([0]), middle), expected, atol=1e-6)


def test_a_file_holds_the_parts_and_the_remarks(tmp_path):
    written(tmp_path)
    cats = load(tmp_path, subject="cat")
    cats.save(tmp_path / "cats.npz")
    found = type(cats).load(tmp_path / "cats.npz")
    assert found.remarks == cats.remarks
    assert any("1 holes" in remark and "left open" in remark for remark in found.remarks)
    assert np.array_equal(found.placements["cuts-1"].face_ids, cats.placements["cuts-1"].face_ids)


def test_a_full_shape_with_a_loose_piece_keeps_the_truth(tmp_path):
    """Triangles of the truth count all faces of the file, also those that are left out."""
    used = written(tmp_path)
    vertices, faces = egg()
    loose = np.array([[0, 0, 9], [1, 0, 9], [0, 1, 9.0]])
    write_off(tmp_path / "null" / "cat.off", np.concatenate([loose, vertices]), [[0, 1, 2], *(faces + 3)])
    for number in (1, 10):
        path = tmp_path / "cuts" / f"cuts_cat_shape_{number}.baryc_gt"
        write_table(path, np.loadtxt(path) + np.array([1, 0, 0, 0]))
    cats = load(tmp_path, subject="cat")
    place = cats.placements["cuts-10"]
    assert len(cats.reference.vertices) == 162
    assert np.allclose(
        cats.reference.at(place.face_ids, place.barycentrics), vertices[used["cuts-10"]], atol=1e-6
    )


def test_several_subjects_need_a_choice(tmp_path):
    written(tmp_path)
    with pytest.raises(InputError, match="several subjects: cat, dog; choose one with the option subject"):
        load(tmp_path)
    assert load(tmp_path, subject="dog").poses == ("null",)
    assert load(tmp_path, subject="cat", kind="holes").poses == ("null",)
    with pytest.raises(InputError, match="kind is 'hole'; choose cuts or holes"):
        load(tmp_path, subject="cat", kind="hole")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, "has no cuts_cat_shape_1.baryc_gt beside it"),
        ("1 1 0 0\n", "baryc_gt' has 1 rows, 'cuts_cat_shape_1.off' .* vertices"),
        ("0 1 0 0\n", "row 1 names no triangle; triangles count from 1"),
        ("321 1 0 0\n", "names number 320 of a target of 320 triangles; its indices may count from 1"),
        ("1 1 1 0\n", "cuts_cat_shape_1.baryc_gt.* of row 1 are no barycentric coordinates"),
        ("1 1 0\n", "cuts_cat_shape_1.baryc_gt.*, line 2, has 4 columns, line 1 3"),
    ],
)  # fmt: skip
def test_a_truth_that_does_not_fit_is_refused(tmp_path, content, message):
    written(tmp_path)
    path = tmp_path / "cuts" / "cuts_cat_shape_1.baryc_gt"
    lines = path.read_text().splitlines(keepends=True)
    if content is None:
        path.unlink()
    else:
        path.write_text(content + ("" if "1 rows" in message else "".join(lines[1:])))
    with pytest.raises(InputError, match=message) as caught:
        load(tmp_path, subject="cat")
    assert "\n" not in str(caught.value)
    assert load(tmp_path, subject="cat", poses=["cuts-10"]).poses == ("cuts-10",)
