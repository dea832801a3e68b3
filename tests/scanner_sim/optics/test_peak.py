"""What every peak detector must do, and that they are found by the names of the configuration."""

from typing import get_args, get_type_hints

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from datasets_gen.records import InputError
from scanner_sim.optics import peak
from scanner_sim.scanner_config import ScannerConfig

METHODS = tuple(peak.DETECTORS)
FIELDS = ("peak", "position", "width", "residual", "accepted")


def gaussian(x, height, position, width):
    return height * np.exp(-(((x - position) / width) ** 2))


def noisy(count, rng):
    """Rows of 11 samples: Gaussians of all heights under noise, some of them saturated."""
    height, place = rng.uniform(0.05, 1.5, (count, 1)), rng.uniform(4.5, 5.5, (count, 1))
    values = gaussian(np.arange(11.0), height, place, 1.5) + 0.03 * rng.standard_normal((count, 11))
    return np.clip(values, 0, 1)


def test_detectors_have_the_names_of_the_configuration():
    assert set(METHODS) == set(get_args(get_type_hints(ScannerConfig)["fit"]))


def test_an_unknown_detector_is_refused_in_one_line():
    with pytest.raises(InputError, match=r"^unknown peak detector 'median'; known ones are reference, "):
        peak.fit(np.zeros((1, 9)), "median")


@given(st.floats(0.01, 1), st.floats(3.5, 6.5), st.floats(0.8, 3))
@settings(max_examples=60, deadline=None)
def test_exact_gaussians_are_recovered_by_both_gaussian_fits(height, position, width):
    values = gaussian(np.arange(10.0), height, position, width)[None]
    for method in ("gaussian", "least_squares"):
        found = peak.fit(values, method)
        got = (found.peak[0], found.position[0], found.width[0])
        assert np.allclose(got, (height, position, width), rtol=1e-4)
        assert found.residual[0] < 1e-4


@pytest.mark.parametrize("method", METHODS)
def test_too_few_samples_give_nan(method):
    rows = np.zeros((4, 9))
    rows[1, 4] = 0.5
    rows[2, 4:6] = 0.5
    rows[3, [0, 8]] = 1.0
    found = peak.fit(rows, method)
    assert all(np.isnan(getattr(found, name)).all() for name in FIELDS[:4])
    assert not found.accepted.any()


@pytest.mark.parametrize("method", METHODS)
def test_empty_input_gives_empty_output(method):
    assert len(peak.fit(np.zeros((0, 9)), method, np.zeros(0)).peak) == 0


@pytest.mark.uncompiled
@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("samples", [7, 8])
def test_a_symmetric_row_has_its_peak_in_the_middle(method, samples):
    middle = (samples - 1) / 2
    for height in (0.8, 2.5):  # the second saturates: a plateau of 3 or 4 samples
        row = np.minimum(gaussian(np.arange(samples), height, middle, 1.5), 1)
        found = peak.fit(row[None], method, np.ones(1))
        assert found.position[0] == pytest.approx(middle, abs=1e-6)


@pytest.mark.parametrize("method", METHODS)
def test_shifting_the_samples_shifts_the_position_alone(method):
    rows = np.pad(noisy(300, np.random.default_rng(0)), ((0, 0), (3, 3)))
    found, shifted = (peak.fit(each, method, np.ones(300)) for each in (rows, np.roll(rows, 3, axis=1)))
    assert np.allclose(shifted.position, found.position + 3, atol=1e-6, equal_nan=True)
    assert np.allclose(shifted.width, found.width, atol=1e-5, equal_nan=True)


@pytest.mark.uncompiled
@pytest.mark.parametrize("method", METHODS)
def test_mirroring_the_samples_mirrors_the_position(method):
    rows = noisy(300, np.random.default_rng(1))
    rows = np.round(rows * 2**20) / 2**20
    found, mirrored = (peak.fit(each, method, np.ones(300)) for each in (rows, rows[:, ::-1]))
    once = [(row == row.max()).sum() == 1 for row in rows]
    assert np.allclose(mirrored.position[once], 10 - found.position[once], atol=1e-6, equal_nan=True)


@pytest.mark.parametrize("method", [each for each in METHODS if each != "reference"])
def test_no_peak_is_above_the_ceiling(method):
    rng = np.random.default_rng(2)
    ceiling = rng.uniform(0.6, 1, 500)
    found = peak.fit(np.minimum(noisy(500, rng), ceiling[:, None]), method, ceiling)
    there = np.isfinite(found.peak)
    assert there.mean() > 0.9
    assert (found.peak[there] <= ceiling[there]).all()


@pytest.mark.parametrize("method", METHODS)
def test_all_are_near_the_truth_without_noise(method):
    """Within a tenth of a sample and of the width; the peak within the dip between two samples.

    The reference's start is as wide as the row, and it may stop there.
    """
    place = np.linspace(4.5, 5.5, 101)
    found = peak.fit(gaussian(np.arange(11.0), 0.4, place[:, None], 1.5), method)
    assert found.accepted.all()
    assert np.abs(found.position - place).max() < 0.1
    if method != "reference":
        assert np.abs(found.peak / 0.4 - 1).max() < 1 - np.exp(-((0.5 / 1.5) ** 2))
        assert np.abs(found.width / 1.5 - 1).max() < 0.1


@pytest.mark.parametrize("method", METHODS)
def test_threads_and_other_rows_change_nothing(method, monkeypatch):
    rows = noisy(9000, np.random.default_rng(3))
    found = []
    for threads in (1, 4):
        monkeypatch.setattr("datasets_gen.compiled.thread_count", lambda threads=threads: threads)
        found.append(peak.fit(rows, method, np.ones(9000)))
    some = peak.fit(rows[5000:5010], method, np.ones(10))
    for name in FIELDS:
        assert np.array_equal(getattr(found[0], name), getattr(found[1], name), equal_nan=True)
        assert np.array_equal(getattr(found[0], name)[5000:5010], getattr(some, name), equal_nan=True)
