import numpy as np
import pytest

from datasets_gen import InputError
from evaluation import run
from evaluation.methods.external import External, export, read_correspondence


@pytest.mark.parametrize("suffix", [".npy", ".npz", ".txt", ".csv"])
@pytest.mark.parametrize("confident", [True, False])
def test_every_format_says_the_same(tmp_path, suffix, confident):
    ids, confidence = np.array([2, 0, -1, 5]), np.array([0.5, 1, 0, 0.25])
    path = tmp_path / f"map{suffix}"
    if suffix == ".npy":
        np.save(path, ids)
    elif suffix == ".npz":
        np.savez(path, source_to_target=ids, **({"confidence": confidence} if confident else {}))
    else:
        table = np.column_stack([ids, confidence]) if confident else ids
        np.savetxt(path, table, delimiter="," if suffix == ".csv" else " ")
    found, trust = read_correspondence(path)
    assert found.tolist() == ids.tolist()
    assert trust.tolist() == (confidence.tolist() if confident and suffix != ".npy" else [1, 1, 0, 1])


@pytest.mark.parametrize(
    ("name", "text"), [("a.txt", "1.5\n2"), ("b.txt", "x"), ("c.npz", "x"), ("d.npy", "")]
)
def test_files_that_hold_no_ids(tmp_path, name, text):
    (tmp_path / name).write_text(text)
    with pytest.raises(InputError, match="not a readable correspondence") as error:
        read_correspondence(tmp_path / name)
    assert "\n" not in str(error.value)


def test_a_folder_must_be_there(tmp_path):
    with pytest.raises(InputError, match="no folder"):
        External(folder=str(tmp_path / "none"))


def test_files_decide_the_version(tmp_path):
    before = External(folder=str(tmp_path)).fingerprint()
    (tmp_path / "a--b.txt").write_text("0\n")
    assert External(folder=str(tmp_path)).fingerprint() != before


@pytest.mark.slow
def test_exported_matched_elsewhere_and_scored(small, tmp_path):
    store = run(small(stability=None), tmp_path / "first", jobs=1)
    pairs = export(store, tmp_path / "elsewhere").read_text().splitlines()
    assert pairs[0] == "source,target,regime"
    answers = tmp_path / "answers"
    answers.mkdir()
    for line in pairs[1:]:
        source, target, *_ = line.split(",")
        a, b = (np.loadtxt(tmp_path / "elsewhere" / "clouds" / f"{key}.xyz") for key in (source, target))
        assert a.shape[1] == 6
        gaps = np.linalg.norm(a[:, None, :3] - b[None, :, :3], axis=2)
        np.savetxt(answers / f"{source}--{target}.txt", gaps.argmin(axis=1) + 1, fmt="%d")
    methods = [{"name": "external", "label": "elsewhere", "folder": str(answers), "first_id": 1}]
    scored = run(small(stability=None, method=methods), tmp_path / "second", jobs=1)
    columns = ["source_pose", "target_pose", "geodesic_mean", "pck_auc"]
    assert scored.failures().empty
    here, there = (each.table()[columns] for each in (store, scored))
    assert np.allclose(here.geodesic_mean.astype(float), there.geodesic_mean.astype(float))
