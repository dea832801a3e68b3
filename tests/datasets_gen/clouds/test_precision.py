"""Rounding against the distances of points: what single precision leaves of a cloud far from the origin."""

import numpy as np
import pytest

from datasets_gen.clouds.precision import rounding_of, spacing
from datasets_gen.points.fibonacci import fibonacci_sphere

BALL = fibonacci_sphere(8000)
APART = np.sqrt(4 * np.pi / 8000)
"""About the distance of neighbours: the side of the square that each point has for itself."""


def test_spacing_is_that_of_places():
    assert spacing(BALL) == pytest.approx(APART, rel=0.15)
    assert spacing(np.repeat(BALL, 18, axis=0)) == spacing(BALL)
    assert spacing(np.zeros((5, 3))) == 0


@pytest.mark.parametrize("offset", [(0, 0, 0), (5e5, 5.4e6, 300)])
def test_double_precision_is_fine_anywhere(offset):
    found = rounding_of(BALL + np.array(offset))
    assert not found.coarse
    assert not found.hopeless
    assert found.words() == ""


def test_single_precision_is_fine_near_the_origin():
    assert rounding_of((BALL + 300).astype(np.float32).astype(float)).words() == ""


def test_single_precision_far_away_is_told_with_its_steps():
    """Between 2^18 and 2^19 single precision has steps of 1/32, between 2^22 and 2^23 of 1/2 (IEEE 754)."""
    found = rounding_of((BALL + np.array([5e5, 0, 0])).astype(np.float32).astype(float))
    assert found.steps[0] == 1 / 32
    assert found.coarse
    assert not found.hopeless
    assert "x has steps of 0.0312" in found.words()
    far = rounding_of((BALL + np.array([5e5, 5.4e6, 300])).astype(np.float32).astype(float))
    assert far.steps[1] == 1 / 2
    assert far.hopeless
    assert "y has steps of 0.5" in far.words()
    assert "subtract the offset" in far.words()


def test_decimals_are_steps_too():
    found = rounding_of(np.round(BALL, 1) + 0.1 * np.pi - 0.1 * np.pi)
    assert not found.hopeless
    assert rounding_of(np.round(BALL, 1)).steps.max() == pytest.approx(0.1)
    assert rounding_of(np.round(BALL, 1)).coarse
    assert not rounding_of(np.round(BALL, 4)).coarse


def test_a_flat_cloud_has_no_steps_across_it():
    flat = BALL * [1, 1, 0] + [0, 0, 5.4e6]
    assert not rounding_of(flat.astype(np.float32).astype(float)).coarse


def test_few_points_far_from_all_others_set_no_steps():
    strewn = np.concatenate([BALL, np.full((20, 3), 5.4e6)]).astype(np.float32).astype(float)
    assert not rounding_of(strewn).coarse
