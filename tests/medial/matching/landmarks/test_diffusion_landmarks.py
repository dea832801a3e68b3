from dataclasses import replace

import numpy as np
import pytest

from medial import MatchConfig
from medial.matching.landmarks.descriptors import describe
from medial.matching.landmarks.diffusion_landmarks import (
    _square_parts,
    _sum_of_nearest,
    landmark_order,
    search_landmarks,
)
from medial.matching.landmarks.extrapolation import extrapolate_landmarks
from medial.matching.landmarks.samples import spectral_samples
from medial.spectrum.times import DECADES, logarithmic_times
from tests.medial.matching_shapes import permuted, unequal_arms

CONFIG = MatchConfig.from_dict({"samples": 60, "times": 7, "candidates": 0.2})


@pytest.fixture(scope="module")
def pair():
    source = unequal_arms()
    _, target = permuted(source)
    times = logarithmic_times(source.eigenvalues, target.eigenvalues, count=CONFIG.times)
    samples = [spectral_samples(x, 60, np.random.default_rng(k)) for k, x in enumerate((source, target))]
    return times, describe(source, times, samples[0]), describe(target, times, samples[1])


def slow_heat(diffusion, x, y, times):
    """m_t(x, y) over the heat trace, by the sums of Eq. 13; areas in units of the total."""
    lam, psi, area = diffusion.eigenvalues, diffusion.eigenfunctions, diffusion.areas.sum()
    out = []
    for t in times:
        decay = np.exp(-lam * t)
        out.append(area * (decay * psi[x] * psi[y]).sum() / decay.sum())
    return np.array(out)


def test_times_follow_the_spectrum(pair):
    times, source, _ = pair
    values = source.diffusion.eigenvalues
    assert len(times) == 7
    np.testing.assert_allclose(times[[0, -1]], [DECADES / values[-1], DECADES / values[1]])
    np.testing.assert_allclose(np.diff(np.log(times)), np.log(times[1] / times[0]))


def test_heat_is_equation_13_over_the_trace(pair):
    times, source, _ = pair
    for x, y in ((0, 0), (5, 300), (200, 17)):
        expected = slow_heat(source.diffusion, x, y, times)
        np.testing.assert_allclose(source.heat(x, np.array([y]))[0], expected, rtol=1e-3, atol=1e-4)
    np.testing.assert_allclose(
        source.signatures(np.array([9]))[0], slow_heat(source.diffusion, 9, 9, times), rtol=1e-3
    )


def test_heat_among_samples_does_not_depend_on_what_was_asked_before(pair):
    _, _, fresh = pair
    alone = [replace(fresh, _kept={}).among_samples(k).copy() for k in (0, 7, 30)]
    for k in (30, 0, 7, 0):
        fresh.among_samples(k)
    for k, each in zip((0, 7, 30), alone, strict=True):
        assert np.array_equal(fresh.among_samples(k), each)
        assert np.array_equal(each, fresh.heat(int(fresh.samples[k]), fresh.samples))


def test_gone_modes_are_zero_not_subnormal(pair):
    """Products with subnormal numbers are many times slower."""
    times, source, _ = pair
    late = describe(source.diffusion, times * np.geomspace(1, 30, len(times)), source.samples)
    exact = np.exp(-np.outer(source.diffusion.eigenvalues, times * np.geomspace(1, 30, len(times))))
    smallest = np.finfo(np.float32).tiny
    assert ((exact > 0) & (exact < smallest)).any()
    assert (late.decay == 0).any()
    weights = late.psi[late.samples].T[:, :, None] * late.decay[:, None, :]
    assert not ((weights != 0) & (np.abs(weights) < smallest)).any()


def slow_search(source, target, order, times):
    """Eq. 16 with loops."""
    sp, sq = source.samples, target.samples
    near = round(CONFIG.candidates * len(sq))
    done, partners = [], []
    for landmark in order:
        own = slow_heat(source.diffusion, sp[landmark], sp[landmark], times)
        other = np.array([slow_heat(target.diffusion, q, q, times) for q in sq])
        candidates = np.argsort(np.linalg.norm(other - own, axis=1))[:near]
        costs = []
        for c in candidates:
            pairs = [*done, (landmark, c)]
            x = [[slow_heat(source.diffusion, sp[a], p, times) for a, _ in pairs] for p in sp]
            y = [[slow_heat(target.diffusion, sq[b], q, times) for _, b in pairs] for q in sq]
            flat_x, flat_y = np.array(x).reshape(len(sp), -1), np.array(y).reshape(len(sq), -1)
            costs.append(np.linalg.norm(flat_x[:, None] - flat_y, axis=2).min(axis=1).sum())
        best = candidates[int(np.argmin(costs))]
        done.append((landmark, best))
        partners.append(best)
    return partners


def test_search_is_equation_16(pair):
    times, source, target = pair
    order = landmark_order(source, times, 11, 2)
    found = search_landmarks(source, target, order, CONFIG)
    assert found.tolist() == slow_search(source, target, order, times)


def test_extrapolation_is_equation_17(pair):
    times, source, target = pair
    landmarks = np.array([[4, 100], [300, 20]])
    rows = np.array([0, 77, 250])
    index, residual = extrapolate_landmarks(source, target, landmarks, rows)
    everything = range(len(target.diffusion))
    for k, p in enumerate(rows):
        total = np.zeros(len(target.diffusion))
        for a, b in [*landmarks, (None, None)]:
            own = slow_heat(source.diffusion, p if a is None else a, p, times)
            theirs = [slow_heat(target.diffusion, q if b is None else b, q, times) for q in everything]
            total += np.linalg.norm(np.array(theirs) - own, axis=1)
        assert total[index[k]] == pytest.approx(total.min(), rel=1e-3)
        assert residual[k] == pytest.approx(total.min(), rel=1e-2)


@pytest.mark.uncompiled
def test_the_sum_of_nearest_distances():
    """Of 7 to the nearest of 5 points, one term of the squares given apart, as Eq. 16's search has it."""
    x, y = np.random.default_rng(0).normal(size=(7, 3)), np.random.default_rng(1).normal(size=(5, 3))
    own = np.random.default_rng(2).normal(size=(2, 7, 1)), np.random.default_rng(3).normal(size=(2, 5, 1))
    before, now = ((a[None, :, 0] - b[:, None, 0]) ** 2 for a, b in zip(*own, strict=True))
    parts = _square_parts(*(each.astype(np.float32) for each in (x, y)))
    found = _sum_of_nearest((before + now).astype(np.float32), *parts)
    square = before + now + ((x[None] - y[:, None]) ** 2).sum(axis=2)
    assert found == pytest.approx(np.sqrt(square.min(axis=0)).sum(), rel=1e-4)
