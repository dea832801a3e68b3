"""Belief in matches."""

from dataclasses import replace

import numpy as np
import pytest

from medial.matching.confidence import confidence_of_fit, confidence_of_residual
from medial.matching.registration.deformation_graph import NodeGraph
from medial.matching.registration.placement import Placement
from medial.matching.registration.refinement import DenseFit
from medial.matching.registration.selection import Rival

COORDINATES = np.random.default_rng(0).standard_normal((120, 3)).astype(np.float32)
GRAPH, ATTACHMENT = NodeGraph.over(COORDINATES, COORDINATES.astype(float), np.arange(120), 12)
SURE = DenseFit(np.arange(120), np.ones(120), np.ones(120), np.ones(120))
SAMPLES = np.arange(0, 120, 2)
LIKELY, NONE = 40.0, -100.0
BEST = Placement(COORDINATES[SAMPLES].astype(float), 1.5)


def confidence(dense, *rivals, probability=1.0):
    """Of the best map of some probability, given rivals and their log-likelihoods relative to it."""
    values = LIKELY + np.array([0.0, *(loss for _, loss in rivals)])
    compared = [Rival(k, value) for k, value in enumerate(values)]
    placements = [BEST, *(place for place, _ in rivals)]
    return confidence_of_fit(dense, 0, compared, NONE, placements, ATTACHMENT, SAMPLES, probability)


def rival(loss, samples=slice(None)):
    places = BEST.places.copy()
    places[samples] += 1.0
    return Placement(places, 0.0), -loss


def test_what_nothing_speaks_against_is_sure():
    assert np.allclose(confidence(SURE), 1)


@pytest.mark.parametrize("name", ["found", "alone", "held"])
def test_each_doubt_counts(name):
    doubt = np.linspace(0, 1, 120)
    assert np.allclose(confidence(replace(SURE, **{name: doubt})), doubt)


def test_doubts_multiply():
    dense = DenseFit(SURE.match, np.full(120, 0.5), np.full(120, 0.8), np.full(120, 0.9))
    assert np.allclose(confidence(dense), 0.36)


@pytest.mark.parametrize(("loss", "belief"), [(0.0, 1 / 2), (1.0, 1 / (1 + np.exp(-1))), (60.0, 1)])
def test_a_rival_shares_the_belief_by_its_likelihood(loss, belief):
    assert np.allclose(confidence(SURE, rival(loss)), belief)


def test_a_rival_is_one_only_where_it_differs():
    near = COORDINATES[SAMPLES][:, 0] > 0.8
    sure = confidence(SURE, rival(0.0, near))
    far = COORDINATES[:, 0] < -0.8
    assert sure[SAMPLES[near]].mean() < 0.8
    assert sure[far].mean() > 0.9
    assert sure.min() >= 0.5


def test_fits_that_agree_are_believed_less_where_their_map_is_improbable():
    same = (BEST, 0.0)
    assert np.allclose(confidence(SURE, same, same), 1)
    assert np.allclose(confidence(SURE, same, same, probability=0.8), 1)
    assert np.allclose(confidence(SURE, same, same, probability=0.4), 0.25)


def test_typical_residuals_are_half_sure():
    residual = np.array([0.0, 1.0, 2.0, 4.0, 100.0])
    sure = confidence_of_residual(residual)
    assert sure[0] == 1
    assert sure[2] == pytest.approx(0.5)
    assert (np.diff(sure) < 0).all()
    assert np.array_equal(confidence_of_residual(np.zeros(3)), np.ones(3))
