"""Which sample is what: a pure function, balanced, split by individuals, without what is held out."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from datasets_gen import InputError
from evaluation.generation import GenerationConfig
from evaluation.generation.sample_plan import SamplePlan, outlines, shard_ranges
from scanner_sim.optics.viewpoints import directions


def planned(**table):
    config = GenerationConfig.from_table({"name": "x", **table})
    return SamplePlan(config, outlines(config))


def several(**table):
    datasets = [
        {"name": "human", "options": {"subjects": 5}},
        {"name": "quadruped", "options": {"subjects": 4}},
    ]
    return planned(**{"dataset": datasets, "validation": 0.25, **table})


def test_samples_do_not_depend_on_which_were_asked_for_before():
    forward = [several().identity("train", index) for index in range(30)]
    plan = several()
    assert [plan.identity("train", index) for index in reversed(range(30))] == forward[::-1]
    assert len({each.seed for each in forward}) == 30
    assert several(seed=1).identity("train", 0) != forward[0]


def test_no_individual_is_in_both_splits():
    plan = several()
    people = {
        split: {plan.identity(split, index).individual for index in range(4 * 200)}
        for split in ("train", "val")
    }
    assert not people["train"] & people["val"]
    assert len(people["train"] | people["val"]) == 5 + 4
    assert len(people["val"]) == 2  # a quarter of five and of four, rounded
    for each in plan.sets:  # the rest pose on which truth lives is of somebody to train with
        assert each.individuals[each.reference] in people["train"]


def test_every_pose_of_a_split_comes_once_before_any_comes_again():
    plan = planned(dataset=[{"name": "human"}], validation=0.0, draw={"per_render": 2})
    poses = plan.sets[0].poses("train")
    order = [plan.identity("train", 2 * render).pose for render in range(3 * len(poses))]
    for cycle in range(3):
        assert sorted(order[cycle * len(poses) : (cycle + 1) * len(poses)]) == sorted(poses)
    assert order[: len(poses)] != order[len(poses) : 2 * len(poses)]


def test_data_sets_take_turns():
    plan = several()
    assert set(Counter(plan.identity("train", index).dataset for index in range(80)).values()) == {40}


def test_samples_of_a_render_divide_the_range_of_thresholds():
    plan = several(draw={"threshold": [0.2, 0.6], "per_render": 4})
    for render in range(20):
        group = [plan.identity("train", 4 * render + part) for part in range(4)]
        assert len({(each.pose, each.render_seed, each.condition.views) for each in group}) == 1
        quarters = sorted(int((each.condition.threshold - 0.2) / 0.1 - 1e-9) for each in group)
        assert quarters == [0, 1, 2, 3]


@pytest.mark.parametrize("up", ["x", "y", "z"])
def test_turned_about_the_axis_that_is_up(up):
    scan = {"views": 3, "scanner": {"up": up}}
    plan = planned(dataset=[{"name": "human"}], scan=scan, draw={"turn": "up"})
    axis, before = "xyz".index(up), directions(3, up)
    angles = []
    for index in range(0, 160, 4):
        after = np.array(plan.identity("train", index).condition.views)
        np.testing.assert_allclose(after[:, axis], before[:, axis], atol=1e-8)
        np.testing.assert_allclose(after @ after.T, before @ before.T, atol=1e-8)
        first, second = (np.delete(each[0], axis) for each in (before, after))
        angles.append(np.arctan2(first[0] * second[1] - first[1] * second[0], first @ second))
    assert min(angles) < -2  # all the way round
    assert max(angles) > 2


def test_turned_about_any_axis_and_not_at_all():
    plan = planned(dataset=[{"name": "human"}], scan={"views": 1}, draw={"turn": "any", "per_render": 1})
    mean = np.mean([plan.identity("train", index).condition.views[0] for index in range(400)], axis=0)
    assert np.abs(mean).max() < 4 / np.sqrt(3 * 400)  # uniform on the sphere: four standard errors
    still = planned(dataset=[{"name": "human"}], scan={"views": 3}, draw={"turn": "none"})
    assert still.identity("train", 5).condition.views == 3


def test_held_out_bodies_and_poses_are_refused_or_marked():
    with pytest.raises(InputError, match=r"'hand': it is held out.*held_out = true"):
        planned(dataset=[{"name": "hand"}])
    kneeling = {"name": "human", "options": {"poses": ["rest", "kneel"]}}
    with pytest.raises(InputError, match="'human': its pose 'kneel' is held out"):
        planned(dataset=[kneeling])
    plan = planned(dataset=[kneeling], held_out=True, draw={"per_render": 1})
    assert {(one.pose, one.held_out) for one in (plan.identity("train", i) for i in range(2))} == {
        ("rest", False),
        ("kneel", True),
    }


@pytest.mark.parametrize("name", ["bodies", "quick"])
def test_presets_are_split_and_have_nothing_held_out(name):
    config = GenerationConfig.load(name)
    plan = SamplePlan(config, outlines(config))
    assert all(len(each.validation) >= 1 and not each.held_out for each in plan.sets)
    assert plan.counts(1000)["val"] == 1000 * config.validation


def test_one_individual_has_no_validation():
    plan = planned(dataset=[{"name": "human"}], validation=0.2)
    assert plan.counts(10) == {"train": 10, "val": 0}
    assert several(validation=0.2).counts(11) == {"train": 9, "val": 2}


def test_wrong_data_sets_are_one_line():
    for dataset, words in (
        ([{"name": "humen"}], "did you mean 'human'"),
        ([{"name": "human"}, {"name": "human"}], "two data sets are called 'human'.*subjects"),
        ([{"name": "human", "poses": ["wolk"]}], "'wolk'; did you mean 'walk'"),
        ([{"name": "human", "options": {"subject": 2}}], "no option 'subject'"),
    ):
        with pytest.raises(InputError, match=words):
            planned(dataset=dataset)


@given(st.integers(1, 300), st.integers(0, 300), st.integers(1, 50))
def test_shards_hold_every_sample_once(train, val, size):
    ranges = shard_ranges({"train": train, "val": val}, size)
    held = [(split, i) for split, _, first, count in ranges for i in range(first, first + count)]
    assert held == [("train", i) for i in range(train)] + [("val", i) for i in range(val)]
    assert all(1 <= count <= size for *_, count in ranges)
    assert len({(split, number) for split, number, *_ in ranges}) == len(ranges)
