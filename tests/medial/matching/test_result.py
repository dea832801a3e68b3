"""`Matching` and its file."""

import dataclasses

import numpy as np
import pytest

from datasets_gen.records import InputError, load_record, save_record
from medial import MatchConfig, Matching
from medial.matching.result import Alternative


def matching(**changes):
    table = {"first": np.array([0, 2]), "partner": np.array([1, 0]), "chosen": np.array([True, False])}
    made = Matching(
        source_to_target=np.array([1, 0, -1]),
        landmarks=np.array([[0, 1], [1, 0]]),
        cost=float("nan"),
        confidence=np.array([0.9, 0.6, 0.0]),
        restarts=table,
        mirror_check="agrees",
        seed=5,
        config=MatchConfig(samples=30),
    )
    return dataclasses.replace(made, **changes)


def test_it_says_in_one_line_what_it_is():
    said = "Matching(3 points, 2 landmarks, mean confidence 0.50"
    assert [repr(matching(mirror_check=word)) for word in ("overruled", "undecided")] == [
        f"{said})",
        f"{said}, mirror check undecided)",
    ]


@pytest.mark.parametrize("clouds", [False, True])
def test_files_round_trip(clouds, tmp_path):
    points = {"source_points": np.eye(3), "target_points": np.ones((2, 3))} if clouds else {}
    saved = matching(**points, about={"method": "medial"})
    saved.save(tmp_path / "map.npz")
    loaded = Matching.load(tmp_path / "map.npz")
    for name in ("source_to_target", "landmarks", "confidence"):
        assert np.array_equal(getattr(saved, name), getattr(loaded, name))
    for name in ("config", "seed", "mirror_check", "about", "alternatives"):
        assert getattr(saved, name) == getattr(loaded, name)
    assert np.isnan(loaded.cost)  # found by path length
    assert set(saved.restarts) == set(loaded.restarts)
    assert loaded.restarts["chosen"].dtype == bool
    for name in ("source_points", "target_points"):
        kept = getattr(loaded, name)
        assert np.array_equal(kept, points[name]) if clouds else kept is None


@pytest.mark.parametrize(
    ("old", "new"), [("kept", "agrees"), ("flipped", "overruled"), ("undecided", "undecided")]
)
def test_words_of_old_files_are_translated(old, new, tmp_path):
    matching().save(tmp_path / "map.npz")
    arrays, meta = load_record(tmp_path / "map.npz", "Matching")
    del meta["mirror_check"], meta["about"]
    meta["config"]["first_mode"] = 1
    save_record(tmp_path / "old.npz", "Matching", arrays, meta | {"flip": old})
    assert Matching.load(tmp_path / "old.npz").mirror_check == new


def test_other_files_are_refused(tmp_path):
    save_record(tmp_path / "scan.npz", "Scan", {}, {})
    with pytest.raises(InputError, match="holds 'Scan', not 'Matching'"):
        Matching.load(tmp_path / "scan.npz")


def test_a_map_is_extended_to_the_clouds_that_its_points_were_picked_from():
    source_ids, target_ids, nearest = np.array([4, 2, 0]), np.array([7, 3]), np.array([2, 2, 1, 0, 0])
    whole = matching().extended(nearest, source_ids, target_ids)
    assert whole.source_to_target.tolist() == [-1, -1, 7, 3, 3]
    assert whole.confidence.tolist() == [0, 0, 0.6, 0.9, 0.9]
    assert whole.landmarks.tolist() == [[4, 3], [2, 7]]
    assert whole.restarts["first"].tolist() == [4, 0]
    assert whole.restarts["partner"].tolist() == [3, 7]


def test_numbers_of_numpy_are_saved(tmp_path):
    matching(seed=np.int64(3), config=MatchConfig(samples=np.int64(30))).save(tmp_path / "m.npz")
    assert Matching.load(tmp_path / "m.npz").seed == 3


def open_question():
    others = (
        Alternative(0.3, np.array([0, 1, 1]), np.array([0.3, 0.3, 0.1])),
        Alternative(0.1, np.array([-1, 0, 0]), np.array([0.0, 0.1, 0.1])),
    )
    return matching(probability=0.6, alternatives=others)


def test_it_says_that_other_maps_may_be_right():
    assert "0.60 against 0.30 0.10 for other maps" in repr(open_question())


def test_alternatives_round_trip(tmp_path):
    open_question().save(tmp_path / "map.npz")
    loaded = Matching.load(tmp_path / "map.npz")
    assert loaded.probability == 0.6
    assert [each.probability for each in loaded.alternatives] == [0.3, 0.1]
    for saved, read in zip(open_question().alternatives, loaded.alternatives, strict=True):
        assert np.array_equal(saved.source_to_target, read.source_to_target)
        assert np.array_equal(saved.confidence, read.confidence)


def test_files_from_before_alternatives_have_none(tmp_path):
    matching().save(tmp_path / "map.npz")
    arrays, meta = load_record(tmp_path / "map.npz", "Matching")
    del meta["probability"]
    save_record(tmp_path / "old.npz", "Matching", arrays, meta)
    loaded = Matching.load(tmp_path / "old.npz")
    assert loaded.alternatives == ()
    assert np.isnan(loaded.probability)


def test_alternatives_are_extended_too():
    source_ids, target_ids, nearest = np.array([4, 2, 0]), np.array([7, 3]), np.array([2, 2, 1, 0, 0])
    other = open_question().extended(nearest, source_ids, target_ids).alternatives[0]
    assert other.source_to_target.tolist() == [3, 3, 3, 7, 7]
    assert other.confidence.tolist() == [0.1, 0.1, 0.3, 0.3, 0.3]


def test_an_alternative_is_a_map_of_its_own():
    first, second = open_question().as_alternatives()
    assert first.source_to_target.tolist() == [0, 1, 1]
    assert first.landmarks.tolist() == [[0, 0], [1, 1]]
    assert (first.probability, second.probability) == (0.3, 0.1)
    assert first.alternatives == ()
    assert first.confidence.tolist() == [0.3, 0.3, 0.1]
