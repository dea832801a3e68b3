import numpy as np
import pytest

from datasets_gen import InputError
from datasets_gen.correspondences.point_map import FORMATS, PointMap
from datasets_gen.correspondences.writing import write_map
from evaluation import run
from evaluation.methods.external import SUFFIXES, External, export


class Cloud:
    """As many points as a pair of the tests has."""

    def __init__(self, name: str, points: int) -> None:
        self.name, self.points = name, points

    def __len__(self) -> int:
        return self.points


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_every_format_says_the_same(tmp_path, suffix):
    ids = np.array([2, 0, -1, 5])
    first = FORMATS[suffix][0] or 0
    if suffix == ".npy":
        np.save(tmp_path / "a--b.npy", ids)
    else:
        write_map(PointMap(ids), tmp_path / f"a--b{suffix}", first_id=first)
    found = External(folder=str(tmp_path)).match(Cloud("a", 4), Cloud("b", 6), seed=0)
    assert found.source_to_target.tolist() == ids.tolist()
    assert found.confidence.tolist() == [1, 1, 0, 1]


def test_ids_of_bare_text_count_from_zero_unless_it_is_said(tmp_path):
    (tmp_path / "a--b.txt").write_text("2 .5\n1 1\n")
    for first, ids in ((None, [2, 1]), (1, [1, 0])):
        method = External(folder=str(tmp_path), first_id=first)
        found = method.match(Cloud("a", 2), Cloud("b", 3), seed=0)
        assert found.source_to_target.tolist() == ids
        assert found.confidence.tolist() == [0.5, 1]


def test_a_map_that_does_not_fit_the_clouds_is_refused(tmp_path):
    (tmp_path / "a--b.txt").write_text("2\n1\n")
    method = External(folder=str(tmp_path))
    with pytest.raises(InputError, match="2 ids for a source of 3"):
        method.match(Cloud("a", 3), Cloud("b", 3), seed=0)
    with pytest.raises(InputError, match="names number 2 of a target of 2 points"):
        method.match(Cloud("a", 2), Cloud("b", 2), seed=0)


def test_a_folder_must_be_there(tmp_path):
    with pytest.raises(InputError, match="no folder"):
        External(folder=str(tmp_path / "none"))


def test_files_decide_the_version(tmp_path):
    def version():
        return External(folder=str(tmp_path)).fingerprint()

    empty = version()
    (tmp_path / "a--b.txt").write_text("0\n")
    first = version()
    (tmp_path / "a--b.txt").write_text("1\n")
    second = version()
    (tmp_path / "a--b.txt").write_text("0\n")
    assert version() == first  # of the same files, whenever they were written
    assert len({empty, first, second}) == 3


@pytest.mark.slow
def test_exported_matched_elsewhere_and_scored(small, tmp_path):
    store = run(small(stability=None), tmp_path / "first", jobs=1)
    pairs = export(store, tmp_path / "elsewhere").read_text().splitlines()
    assert pairs[0] == "source,target,regime"
    assert len(pairs) == 1 + 2  # the reference to each other pose
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
