"""The method ``skeleton`` beyond what every method promises (`test_contract`)."""

import numpy as np
import pytest

from datasets_gen.records import InputError
from evaluation.methods import MethodInput, create
from reports.cli.cloud_files import bare_scan
from tests.medial.clouds import body, rotation, sphere
from tests.medial.skeletons import tubes


def given(points, normals, name="a"):
    return MethodInput(name, bare_scan(points, normals, name))


@pytest.mark.parametrize("skeleton", ["rosa", "medial"])
def test_a_body_is_found_again_after_a_turn(skeleton):
    """Four unequal limbs and a head: every point goes near itself."""
    points, normals = body(900)
    turn = rotation(3)
    found = create("skeleton", {"skeleton": skeleton}).match(
        given(points, normals), given(points @ turn.T, normals @ turn.T, "b"), 0
    )
    away = np.linalg.norm(points[found.source_to_target] - points, axis=1)
    assert np.median(away) < 0.05
    assert np.mean(away) < 0.1
    sure = found.confidence > np.median(found.confidence)
    assert away[sure].mean() <= away[~sure].mean()


def test_another_unit_changes_nothing():
    points, normals = body(700)
    method = create("skeleton", {})
    first = method.match(given(points, normals), given(points, normals, "b"), 0)
    second = method.match(given(points, normals), given(40 * points, normals, "b"), 0)
    gap = np.linalg.norm(points[first.source_to_target] - points[second.source_to_target], axis=1)
    assert np.mean(gap) < 0.05


def test_a_ball_is_refused_with_the_reason():
    points, normals = sphere(300)
    with pytest.raises(InputError, match=r"'ball' has no curve skeleton: .* a ball has no axis"):
        create("skeleton", {}).match(given(points, normals, "ball"), given(points, normals), 0)


def test_rings_have_nothing_to_match():
    ring = tubes.ring(600)
    with pytest.raises(InputError, match="no tips or joints"):
        create("skeleton", {}).match(given(ring.points, ring.normals), given(ring.points, ring.normals), 0)


@pytest.mark.parametrize(
    ("options", "said"),
    [({"skeleton": "rosy"}, "rosy"), ({"tried": 0}, "tried must be at least 1"), ({"steps": 3}, "steps")],
    ids=["skeleton", "tried", "unknown"],
)
def test_options_are_checked(options, said):
    with pytest.raises(InputError, match=said):
        create("skeleton", options)
