"""Peaks of a field on a graph, of which limbs are found: small enough to follow without Numba."""

import numpy as np
import pytest

from evaluation.metrics.limbs import _islands

pytestmark = pytest.mark.uncompiled


def islands_of(field, least):
    """Of a field along a line; peaks and where they meet the rest."""
    field = np.array(field, float)
    neighbours = [[k for k in (v - 1, v + 1) if 0 <= k < len(field)] for v in range(len(field))]
    indptr = np.cumsum([0, *map(len, neighbours)])
    order = np.argsort(-field, kind="stable")
    tips, feet = _islands(order, indptr, np.concatenate(neighbours), field, least)
    return sorted(zip(tips.tolist(), feet.tolist(), strict=True))


def test_two_hills_with_a_valley_stand_out_by_their_height_above_it():
    assert islands_of([0, 5, 1, 4, 0], least=2.0) == [(1, 1.0), (3, 1.0)]


def test_a_hill_lower_than_the_least_belongs_to_its_neighbour():
    assert islands_of([0, 5, 3, 4, 0], least=2.0) == []


def test_a_third_hill_joins_the_trunk_of_two():
    assert islands_of([6, 1, 5, 0, 4], least=2.0) == [(0, 1.0), (2, 1.0), (4, 0.0)]
