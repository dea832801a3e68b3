import numpy as np
import pytest

from datasets_gen import InputError, load
from datasets_gen.registry import outline
from tests.datasets_gen.collections.layout_files import egg, write_off


def write_poses(folder, names, faces=None):
    for number, name in enumerate(names):
        vertices, own = egg(0.01 * number)
        write_off(folder / f"{name}.off", vertices, own if faces is None else faces)


def test_scape_has_no_051_and_two_splits(tmp_path):
    numbers = [k for k in range(48, 55) if k != 51]
    write_poses(tmp_path, [f"mesh{k:03}" for k in numbers])
    assert load(tmp_path).poses == tuple(f"mesh{k:03}" for k in numbers)
    assert load(tmp_path, split="train").poses == ("mesh048", "mesh049", "mesh050")
    test = load(tmp_path, split="test")
    assert test.poses == ("mesh052", "mesh053", "mesh054")
    assert test.reference.pose == "mesh048"
    assert outline(tmp_path, split="test") == {
        "subject": "scape", "poses": list(test.poses), "reference": "mesh048",
    }  # fmt: skip
    with pytest.raises(InputError, match="split is 'val'; choose train or test"):
        load(tmp_path, split="val")


def test_doubled_faces_are_dropped_from_all_poses_alike(tmp_path):
    faces = egg()[1]
    doubled = np.concatenate([faces, faces[[7]], np.roll(faces[[9]], 1)])
    write_poses(tmp_path, ["mesh000", "mesh001"], doubled)
    found = load(tmp_path)
    assert len(found.reference.faces) == len(faces)
    assert np.array_equal(found["mesh001"].faces, found.reference.faces)
    assert any("2 faces repeat others: dropped" in remark for remark in found.remarks)


def test_quads_are_cut_alike_in_all_poses(tmp_path):
    """A cube of six squares has 12 triangles."""
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    for number in (0, 1):
        write_off(tmp_path / f"mesh{number:03}.off", corners * [1, 1, 1 + number], quads, newline="\r\n")
    found = load(tmp_path)
    assert found.reference.faces.shape == (12, 3)
    assert found["mesh001"].area == pytest.approx(2 + 4 * 2)


def test_obj_files_with_normals(tmp_path):
    """Corners such as ``3//3``."""
    for number in (0, 1):
        vertices, faces = egg(0.1 * number)
        lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices] + ["vn 0 0 1"]
        lines += ["f " + " ".join(f"{k + 1}//1" for k in face) for face in faces]
        (tmp_path / f"mesh{number:03}.obj").write_text("\r\n".join(lines) + "\r\n")
    assert np.allclose(load(tmp_path)["mesh001"].vertices, egg(0.1)[0])


def test_other_faces_are_refused(tmp_path):
    write_poses(tmp_path, ["mesh000"])
    write_poses(tmp_path, ["mesh001"], egg()[1][::-1])
    with pytest.raises(InputError, match=r"mesh001.off' has other faces than 'mesh000.off'"):
        load(tmp_path)


@pytest.mark.parametrize("inside", ["training/registrations", "registrations", "."])
def test_faust_people_and_splits(tmp_path, inside):
    folder = tmp_path / inside
    write_poses(folder, [f"tr_reg_{k:03}" for k in (0, 1, 10, 79, 80, 99)])
    found = load(tmp_path, people=[0, 8])
    assert found.poses == ("tr_reg_000", "tr_reg_001", "tr_reg_080")
    assert load(tmp_path, split="test").poses == ("tr_reg_080", "tr_reg_099")
    assert outline(tmp_path, split="train", people=[7])["poses"] == ["tr_reg_079"]
    for wrong in ([10], 3, [], ["a"]):
        with pytest.raises(InputError, match="give a list of numbers from 0 to 9"):
            outline(tmp_path, people=wrong)
    with pytest.raises(InputError, match="no files of what is asked for"):
        load(tmp_path, people=[5])


def test_scans_of_faust_are_no_ground_truth(tmp_path):
    write_poses(tmp_path / "training" / "scans", ["tr_scan_000", "tr_scan_001"])
    with pytest.raises(InputError, match="no exact ground truth; add training/registrations, or use"):
        load(tmp_path)
