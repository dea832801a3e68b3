"""Skeletons against bones."""

from dataclasses import replace

import numpy as np
import pytest

from datasets_gen import load
from datasets_gen.records import InputError
from evaluation.metrics.skeleton_score import matched_ends, skeleton_score
from evaluation.metrics.skeleton_truth import BoneSegments, known_bones
from medial.skeletons import CurveSkeleton

STARTS = np.array([[0.0, 0, 0], [0, 1, 0], [0, 1, 0]])
ENDS = np.array([[0.0, 1, 0], [1, 2, 0], [-1, 2, 0]])
BONES = BoneSegments(STARTS, ENDS, np.array([[0.0, 0, 0], [1, 2, 0], [-1, 2, 0]]))


def letter(shift=0.0, edges=((0, 1), (1, 2), (1, 3))):
    places = np.array([[0.0, 0, 0], [0, 1, 0], [1, 2, 0], [-1, 2, 0], [0.4, 0.5, 0]])
    nodes = np.add(places, [0, 0, shift])
    kept = sorted({k for edge in edges for k in edge})
    renumbered = np.array([[kept.index(a), kept.index(b)] for a, b in edges])
    return CurveSkeleton(nodes[kept], renumbered, np.ones(len(kept)), np.zeros(0, np.int64))


def test_a_perfect_skeleton():
    score = skeleton_score(letter(), BONES, area=4.0)
    assert score.right
    assert score.to_bones == pytest.approx(0, abs=1e-9)
    assert score.from_bones < 0.5


def test_distances_are_per_root_of_the_area():
    score = skeleton_score(letter(0.1), BONES, area=4.0)
    assert score.to_bones == pytest.approx(100 * 0.1 / 2)
    assert score.from_bones == pytest.approx(100 * 0.1 / 2, rel=0.01)


def test_branches_too_many_and_too_few():
    more = skeleton_score(letter(edges=((0, 1), (1, 2), (1, 3), (1, 4))), BONES, 4.0)
    assert (more.spurious, more.missing, more.right) == (1, 0, False)
    less = skeleton_score(letter(edges=((0, 1), (1, 2))), BONES, 4.0)
    assert (less.spurious, less.missing, less.right) == (0, 1, False)
    assert less.from_bones > 10


def test_a_loop_is_wrong():
    score = skeleton_score(letter(edges=((0, 1), (1, 2), (1, 3), (2, 3))), BONES, 4.0)
    assert score.loops == 1
    assert not score.right


def test_no_skeleton():
    score = skeleton_score(CurveSkeleton.empty(5, "rosa", "flat"), BONES, 4.0)
    assert (score.spurious, score.missing, score.parts) == (0, 3, 0)
    assert np.isnan(score.to_bones)


def test_ends_are_paired_one_to_one():
    found = np.array([[0.0, 0, 0], [0.1, 0, 0]])
    assert matched_ends(found, np.array([[0.0, 0, 0]]), 1.0) == 1
    assert matched_ends(found, np.array([[0.05, 0, 0], [0.9, 0, 0]]), 1.0) == 2
    assert matched_ends(found, np.zeros((0, 3)), 1.0) == 0


@pytest.mark.parametrize(
    ("name", "pose", "tips"),
    [("human", "tpose", 5), ("human", "arms_up", 5), ("quadruped", "walk", 8)],
    ids=lambda each: str(each),
)
def test_bones_lie_within_the_posed_body(name, pose, tips):
    """Two hands, two feet and the head; muzzle, two ears, the tail and four hooves."""
    body = load(name)
    bones = known_bones(body, pose)
    assert len(bones.tips) == tips
    low, high = body[pose].vertices.min(axis=0), body[pose].vertices.max(axis=0)
    places = bones.sampled(0.05)
    assert (places > low).all()
    assert (places < high).all()
    assert bones.distances(places).max() < 1e-12
    skin = body[pose].vertices
    gaps = np.linalg.norm(skin[None] - bones.tips[:, None], axis=2).min(axis=1)
    assert gaps.max() < 0.1 * np.sqrt(body.reference.area)


def test_bodies_without_bones_are_refused():
    with pytest.raises(InputError, match="the bones of 'torus' are not known; known are those of human"):
        known_bones(replace(load("human"), subject="torus"), "rest")
