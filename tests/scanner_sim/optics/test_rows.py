"""Rows of samples against plain loops."""

import numpy as np

from scanner_sim.optics.rows import Rows
from scanner_sim.optics.stripe import SweptStripes


def some_rows(seed=0):
    """Rows of 6 pixels as the sum over 15 points with stripes of width 4."""
    rng = np.random.default_rng(seed)
    row = np.sort(np.concatenate([np.arange(6), rng.integers(6, size=9)]))
    swept = SweptStripes(rng.integers(20, 40, 15), rng.random((15, 4)))
    weights = rng.random(15)
    return row, swept, weights, Rows.gathered(row, 6, swept, weights)


def dense(row, swept, weights):
    out = np.zeros((6, 60))
    for i in range(len(row)):
        for j in range(4):
            out[row[i], swept.first[i] + j] += weights[i] * swept.values[i, j]
    return out


def test_gathered_rows_are_sums_over_their_points():
    row, swept, weights, rows = some_rows()
    expected = dense(row, swept, weights)
    for i in range(6):
        values = rows.values[rows.start[i] : rows.start[i] + rows.stop[i] - rows.first[i]]
        assert np.allclose(values, expected[i, rows.first[i] : rows.stop[i]])
        assert np.isclose(values.sum(), expected[i].sum())
    assert np.allclose(rows.largest(), expected.max(axis=1))


def test_stripes_name_every_sample():
    row, swept, weights, rows = some_rows()
    number, stripe = rows.stripes()
    assert np.allclose(rows.values, dense(row, swept, weights)[number, stripe])


def test_selected_and_padded_rows_hold_the_same_samples():
    _, _, _, rows = some_rows()
    index = np.array([4, 1])
    few = rows.select(index)
    assert (few.first == rows.first[index]).all()
    assert np.allclose(few.padded(np.arange(2)), rows.padded(index))


def test_blocks_hold_every_row_once():
    _, _, _, rows = some_rows()
    assert sorted(np.concatenate(list(rows.blocks()))) == list(range(6))
    empty = Rows(np.empty(0, np.int64), np.empty(0, np.int64), np.empty(0))
    assert list(empty.blocks()) == []


def test_of_two_runs_of_lit_samples_the_brightest_is_kept():
    values = np.array([0.1, 0.3, 0, 0, 0.5, 0.2, 0.0, 0.0, 0.4, 0.2, 0.0, 0.0])
    rows = Rows(np.array([10, 20, 30]), np.array([16, 22, 34]), values)
    first, stop = rows.brightest_runs()
    assert first.tolist() == [14, 20, 30]
    assert stop.tolist() == [16, 22, 32]
    cut = rows.cut(first, stop)
    assert cut.values.tolist() == [0.5, 0.2, 0.0, 0.0, 0.4, 0.2]


def test_empty_rows_stay_empty():
    rows = Rows(np.array([0, 7, 20]), np.array([3, 7, 23]), np.array([0.1, 0.4, 0.0, 0.2, 0.0, 0.5]))
    first, stop = rows.brightest_runs()
    assert first.tolist() == [0, 7, 22]
    assert stop.tolist() == [2, 7, 23]
    assert rows.cut(first, stop).values.tolist() == [0.1, 0.4, 0.5]
    assert sorted(np.concatenate(list(rows.blocks()))) == [0, 1, 2]
