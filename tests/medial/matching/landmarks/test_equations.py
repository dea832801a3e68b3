"""The landmark search and the extrapolation are Eqs. 16 and 17, with and without the clouds' own areas."""

from types import SimpleNamespace

import numpy as np
import pytest

from medial import MatchConfig
from medial.matching.landmarks.descriptors import describe
from medial.matching.landmarks.diffusion_landmarks import nearest_signatures, search_landmarks
from medial.matching.landmarks.equations import (
    extrapolated,
    kernel_over_times,
    landmark_cost,
    landmark_partner,
)
from medial.matching.landmarks.extrapolation import extrapolate_landmarks
from medial.spectrum.times import logarithmic_times
from tests.medial.matching_shapes import permuted, unequal_arms

CONFIG = MatchConfig.from_dict({"times": 7, "candidates": 0.2})


@pytest.fixture(scope="module", params=[True, False], ids=["own area", "as written"])
def clouds(request):
    """Two clouds with 60 samples each, prepared for the search, and their m_o between all points."""
    source = unequal_arms()
    _, target = permuted(source)
    times = logarithmic_times(source.eigenvalues, target.eigenvalues, count=CONFIG.times)
    made = []
    for seed, each in enumerate((source, target)):
        samples = np.sort(np.random.default_rng(seed).choice(len(each), 60, replace=False))
        area = each.areas.sum() if request.param else 1.0
        kernel = kernel_over_times(each.eigenvalues, each.eigenfunctions, times, area)
        prepared = describe(each, times, samples, area_normalised=request.param)
        made.append(SimpleNamespace(prepared=prepared, kernel=kernel, samples=samples))
    return made


def test_kernel_over_times(clouds):
    cloud = clouds[0]
    found = np.array([cloud.prepared.heat(x, slice(None)) for x in (3, 40)])
    assert found == pytest.approx(cloud.kernel[[3, 40]], abs=1e-4 * np.abs(cloud.kernel).max())


def test_search_is_equation_16(clouds):
    source, target = clouds
    order = np.array([11, 40, 3])
    found = search_landmarks(source.prepared, target.prepared, order, CONFIG)
    here = source.kernel[np.ix_(source.samples, source.samples)]
    there = target.kernel[np.ix_(target.samples, target.samples)]
    before = np.zeros((60, 60))
    for landmark, partner in zip(order, found, strict=True):
        signatures = source.prepared.signature[landmark], target.prepared.signature
        candidates = nearest_signatures(*signatures, CONFIG.candidates)
        best = candidates[landmark_partner(here[landmark], there[candidates], before)]
        costs = [landmark_cost(here[landmark], there[each], before) for each in (partner, best)]
        assert costs[0] == pytest.approx(costs[1], rel=1e-5)  # single precision may take the other of equals
        before += ((there[partner][:, None] - here[landmark]) ** 2).sum(axis=2)


def test_extrapolation_is_equation_17(clouds):
    source, target = clouds
    landmarks = np.array([[4, 100], [300, 20]])
    index, cost = extrapolate_landmarks(source.prepared, target.prepared, landmarks, slice(None))
    here, there = (each.kernel for each in clouds)
    signatures = [np.einsum("xxt->xt", each) for each in (here, there)]
    written, least = extrapolated(here[landmarks[:, 0]], there[landmarks[:, 1]], *signatures)
    taken = np.linalg.norm(signatures[0] - signatures[1][index], axis=1)
    for p, q in landmarks:
        taken += np.linalg.norm(here[p] - there[q][index], axis=1)
    assert taken == pytest.approx(least, rel=5e-3)  # single precision may take the other of equals
    assert cost == pytest.approx(least, rel=1e-2, abs=1e-3 * least.max())
    assert (index == written).mean() > 0.95


N, M, TIMES = 4, 5, np.array([0.2, 0.9, 2.0])
RANDOM = np.random.default_rng(0)
SOURCE, TARGET = RANDOM.uniform(size=(2, N, 3)), RANDOM.uniform(size=(2, M, 3))
SOURCE_SIGNATURE, TARGET_SIGNATURE = RANDOM.uniform(size=(N, 3)), RANDOM.uniform(size=(M, 3))


def test_loops_of_the_kernel_over_the_heat_trace():
    """Eq. 13 over the sum of the decayed modes, at each time."""
    values, functions = np.array([0.0, 0.6, 1.7]), RANDOM.normal(size=(N, 3))
    written = np.zeros((N, N, 3))
    for x in range(N):
        for y in range(N):
            for t, time in enumerate(TIMES):
                decayed = [np.exp(-value * time) for value in values]
                heat = sum(decayed[k] * functions[x, k] * functions[y, k] for k in range(3))
                written[x, y, t] = heat / sum(decayed)
    assert kernel_over_times(values, functions, TIMES) == pytest.approx(written)
    assert kernel_over_times(values, functions, TIMES, 7.0) == pytest.approx(7 * written)


def costs_by_loops(source, target, found):
    """Distance of every source sample to the nearest target sample, summed up."""
    total = 0.0
    for p in range(len(source)):
        total += min(np.sqrt(sum((source[p] - target[q]) ** 2) + found[q][p]) for q in range(len(target)))
    return total


def test_loops_of_the_cost_of_a_landmark():
    """Eq. 16, for the first landmark and with coordinates of others."""
    nothing, before = np.zeros((M, N)), RANDOM.uniform(0, 0.3, (M, N))
    source, targets = SOURCE[0], np.concatenate([TARGET, TARGET[:, ::-1] * 0.7, [TARGET[0] + 1]])
    assert landmark_cost(source, targets[0]) == pytest.approx(costs_by_loops(source, targets[0], nothing))
    for found, given in ((nothing, None), (before, before)):
        costs = [costs_by_loops(source, each, found) for each in targets]
        assert [landmark_cost(source, each, given) for each in targets] == pytest.approx(costs)
        assert landmark_partner(source, targets, given) == np.argmin(costs)
    assert landmark_partner(source, np.stack([TARGET[0] + 9, TARGET[0] + 3, source[[0, 1, 2, 3, 3]]])) == 2


def test_loops_of_the_extrapolation():
    """Eq. 17: agreement with both landmarks and in the signature."""
    costs = np.zeros((N, M))
    for p in range(N):
        for q in range(M):
            costs[p, q] = np.sqrt(sum((SOURCE_SIGNATURE[p] - TARGET_SIGNATURE[q]) ** 2))
            for landmark in range(2):
                costs[p, q] += np.sqrt(sum((SOURCE[landmark, p] - TARGET[landmark, q]) ** 2))
    partners, least = extrapolated(SOURCE, TARGET, SOURCE_SIGNATURE, TARGET_SIGNATURE)
    assert partners.tolist() == [min(range(M), key=lambda q: costs[p, q]) for p in range(N)]
    assert least == pytest.approx([min(row) for row in costs])
