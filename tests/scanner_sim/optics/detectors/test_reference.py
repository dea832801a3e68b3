"""The detector of [BLN*11] against its description, written out in plain loops."""

import math

import numpy as np
import pytest

from scanner_sim.optics import peak

STEP = math.radians(0.15589670870248065)
"""Between two stripes of the default sweep, about."""

STRIPE = math.radians(450 / 400)
"""Full angle F of the default stripe."""


def plain(row, step):
    """Peak, position, width, relative residual and verdict of one row; None with fewer than 3 samples."""
    pairs = [(i * step, value) for i, value in enumerate(row) if value > 1e-6]
    if len(pairs) < 3:
        return None
    x, y = map(np.array, zip(*pairs, strict=True))
    mean = float((x * y).sum() / y.sum())
    now = np.array([y.max(), mean, math.sqrt(((x - mean) ** 2).mean())])

    def residuals(p):
        return p[0] * np.exp(-((x - p[1]) ** 2) / p[2] ** 2) - y

    def jacobian(p):
        e = np.exp(-((x - p[1]) ** 2) / p[2] ** 2)
        by_position = p[0] * e * 2 * (x - p[1]) / p[2] ** 2
        by_width = p[0] * e * 2 * (x - p[1]) ** 2 / p[2] ** 3
        return np.stack([e, by_position, by_width], axis=1)

    damping, v = None, 2.0
    for _ in range(50):
        r = residuals(now)
        squares = float((r**2).sum())
        if squares / len(x) < 0.01:
            break
        j = jacobian(now)
        if damping is None:
            damping = 1e-5 * float((j.T @ j).diagonal().max())
        gradient = j.T @ r
        delta = np.linalg.solve(j.T @ j + damping * np.eye(3), -gradient)
        new = 0.5 * float((residuals(now + delta) ** 2).sum())
        gain = (0.5 * squares - new) / (0.5 * float(delta @ (damping * delta - gradient)))
        if gain > 0:
            now = now + delta
            damping *= max(1 / 3, 1 - (2 * gain - 1) ** 3)
            v = 2.0
        else:
            damping *= v
            v *= 2
    residual = math.sqrt(squares / len(x)) / now[0]
    return now[0], now[1] / step, abs(now[2]) / step, residual, 0.5 * squares <= 0.1


def stripes(count, rng, *, noise, bits=8):
    """Rows as the reference program sees them: the wedge on surfaces of all cosines, speckled, truncated."""
    x = np.arange(9.0)
    offset = (x - rng.uniform(3.5, 4.5, (count, 1))) * STEP
    cast = np.exp(-8 * (np.sin(offset) / math.tan(STRIPE / 2)) ** 2) * (np.abs(offset) <= STRIPE / 2)
    taken = np.minimum(cast, noise) * np.exp(-2 * rng.standard_normal(cast.shape) ** 2)
    light = np.clip(cast * rng.uniform(0.05, 1, (count, 1)) - taken, 0, 1)
    levels = 2**bits - 1
    return np.floor(light * levels) / levels


@pytest.mark.parametrize("step", [STEP, 1.0])
def test_it_does_what_its_description_says(step):
    """To 1e-12, but where a fit that never converges amplifies rounding: one row in thousands, to 1e-8."""
    rows = stripes(2000, np.random.default_rng(0), noise=0.35)
    found = peak.fit(rows, "reference", step=step)
    got = np.stack([found.peak, found.position, found.width, found.residual], axis=1)
    expected = [plain(row, step) for row in rows]
    few = np.array([each is None for each in expected])
    assert np.isnan(got[few]).all()
    assert not found.accepted[few].any()
    written = np.array([each for each in expected if each is not None])
    error = np.abs(got[~few] - written[:, :4]) / np.maximum(np.abs(written[:, :4]), 1)
    assert error.max() < 1e-8
    assert (error.max(axis=1) > 1e-12).sum() <= 2
    assert np.array_equal(found.accepted[~few], written[:, 4] == 1)
    assert (found.peak[~few] != rows[~few].max(axis=1)).sum() > 300


@pytest.mark.uncompiled
def test_rows_of_three_samples_and_more_are_refined_as_described():
    rows = stripes(150, np.random.default_rng(4), noise=0.35)
    rows = rows[(rows > 1e-6).sum(axis=1) >= 3]
    found = peak.fit(rows, "reference", step=STEP)
    got = np.stack([found.peak, found.position, found.width, found.residual, found.accepted], axis=1)
    assert len(rows) > 80
    assert (found.peak != rows.max(axis=1)).sum() > 20
    assert got == pytest.approx(np.array([plain(row, STEP) for row in rows]), rel=1e-8)


def test_where_it_begins_within_the_tolerance_it_keeps_centre_of_mass_and_largest_sample():
    rows = stripes(2000, np.random.default_rng(1), noise=0.0) * 0.5
    found = peak.fit(rows, "reference", step=STEP)
    assert np.array_equal(found.peak, rows.max(axis=1))
    assert np.allclose(found.position, rows @ np.arange(9.0) / rows.sum(axis=1), atol=1e-12)


@pytest.mark.uncompiled
def test_seven_samples_of_the_default_sweep_begin_two_steps_wide():
    """sqrt(mean of (-3..3)^2) = 2 samples of .156 degrees."""
    row = 0.3 * np.exp(-(((np.arange(9.0) - 4) / 1.275) ** 2)) * (np.abs(np.arange(9.0) - 4) < 3.5)
    found = peak.fit(row[None], "reference", step=STEP)
    assert found.width[0] == pytest.approx(2)
    assert math.degrees(found.width[0] * STEP) == pytest.approx(0.312, abs=5e-4)


def test_share_of_pixels_that_keep_the_start_is_that_of_the_program():
    """68 to 71 % of the program's pixels on closed bodies; here the cosines of a sphere seen from afar."""
    rng = np.random.default_rng(2)
    cosine = np.sqrt(rng.uniform(0.01, 1, (20_000, 1)))
    offset = (np.arange(9.0) - rng.uniform(3.5, 4.5, (20_000, 1))) * STEP
    cast = np.exp(-8 * (np.sin(offset) / math.tan(STRIPE / 2)) ** 2) * (np.abs(offset) <= STRIPE / 2)
    rows = np.floor(cosine * cast * 255) / 255
    found = peak.fit(rows, "reference", step=STEP)
    assert 0.64 < (found.peak == rows.max(axis=1)).mean() < 0.75


def test_refined_noise_free_peaks_have_the_width_of_the_stripe():
    """Fits of the program's output that iterated have s / F = .176; the stripe's own is tan(F/2) / sqrt 8."""
    rows = stripes(4000, np.random.default_rng(3), noise=0.0, bits=8)
    found = peak.fit(rows, "reference", step=STEP)
    refined = found.peak != rows.max(axis=1)
    assert np.median(found.width[refined]) * STEP / STRIPE == pytest.approx(0.1763, rel=0.05)


@pytest.mark.uncompiled
def test_what_no_gaussian_describes_is_not_accepted():
    rows = np.array([[0.0, 1, 0.01, 0.01, 0.01, 0.01, 0.01, 1, 0]])
    found = peak.fit(rows, "reference", step=STEP)
    assert not found.accepted[0]
    assert found.residual[0] > 0.1
