"""The weights of the matcher's evidence: likelihood, fit and judgement on tables made up for it."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from medial.matching.registration.deformation_graph import Pose
from medial.matching.registration.evidence import Weights, log_likelihood
from medial.matching.registration.fit import Fit
from tests.benchmarks import choice_model

TRUE = np.array([2.0, 1.5, 1.2, 1.8])


def simulated(sets=400, finalists=10, scale=1.0):
    """Choice sets of which one finalist each is right, drawn by the model itself."""
    rng = np.random.default_rng(0)
    evidence = rng.normal(size=(sets, finalists, len(TRUE)))
    chosen = (evidence @ TRUE + rng.gumbel(size=(sets, finalists))).argmax(axis=1)
    right = np.zeros((sets, finalists), bool)
    right[np.arange(sets), chosen] = True
    common = rng.normal(size=(sets, 1, len(TRUE)))  # what all finalists of a pair share says nothing
    return (evidence + common).reshape(-1, len(TRUE)) * scale, np.arange(sets) * finalists, right.ravel()


def fit_of(weights, seen=1.4, missed=0.3, strain=4e-4, held=0.9):
    pose = Pose(np.eye(3)[None], np.zeros((1, 3)))
    found = np.full(5, seen / 2)
    return Fit(pose, np.zeros((5, 3)), np.arange(5), found, found, missed, strain, held, weights)


def table_of(weights, bodies=("a", "b", "c")):
    """Finalists of four pairs a body; the best of each has the least strain, a third as much error."""
    rng = np.random.default_rng(1)
    rows = []
    for body in bodies:
        for pair in range(4):
            for finalist in range(5):
                quick = {"seen": 1.4, "missed": 0.3, "strain": 4e-4 + 1e-4 * finalist, "held": 0.9}
                strain, gap = 2e-4 * (1 + finalist), rng.uniform(0.1, 0.12)
                fine = {"fine_strain": strain, "medial": gap, "fine_missed": 0.2}
                score = fit_of(weights, **quick).score - weights.paths * 0.02
                rows.append(
                    {"body": body, "pair": str(pair), "regime": "r", "finalist": finalist, "score": score}
                    | {"paths": 0.02, "error": 1.0 if finalist == 0 else 20.0}
                    | quick
                    | fine
                    | {"log_likelihood": log_likelihood(weights, score, *fine.values())}
                )
    return pd.DataFrame(rows)


def test_likelihood_of_one_choice_set_by_hand():
    right = np.array([True, False, True])
    found = choice_model.loss(np.log([2.0, 5.0, 3.0]), np.array([0]), right)
    assert found == pytest.approx(-np.log((2 + 3) / (2 + 5 + 3)))


def test_likelihood_is_a_mean_over_choice_sets():
    likelihood, right = np.log([1.0, 3.0, 1.0, 1.0]), np.array([True, False, True, True])
    assert choice_model.loss(likelihood, np.array([0, 2]), right) == pytest.approx(np.log(4) / 2)


def test_a_constant_of_a_choice_set_does_not_count():
    evidence, starts, right = simulated(sets=5)
    shift = np.repeat(np.arange(5.0) * 1000, 10)
    assert choice_model.loss(evidence @ TRUE + shift, starts, right) == pytest.approx(
        choice_model.loss(evidence @ TRUE, starts, right)
    )


@pytest.mark.parametrize("scale", [1.0, 1e-4])
def test_weights_are_recovered(scale):
    evidence, starts, right = simulated(scale=scale)
    fitted = choice_model.fit(evidence, starts, right, ridge=1e-4)
    np.testing.assert_allclose(fitted * scale, TRUE, rtol=0.15)


def test_evidence_that_never_differs_weighs_nothing():
    evidence, starts, right = simulated(sets=50)
    evidence[:, 2] = 0.3
    fitted = choice_model.fit(evidence, starts, right)
    assert fitted[2] == pytest.approx(0, abs=1e-6)
    others = [0, 1, 3]
    alone = choice_model.fit(evidence[:, others], starts, right)
    np.testing.assert_allclose(fitted[others], alone, rtol=1e-3)


def test_right_are_those_with_nearly_the_least_error_of_their_set():
    right = choice_model.right_ones(np.array([2.0, 3.2, 3.3, 9.0, 12.0]), np.array([0, 3]))
    assert right.tolist() == [True, True, False, True, True]


def test_judge_by_hand():
    found = choice_model.judge(
        np.log([1.0, 3.0, 4.0, 1.0]), np.array([1.0, 21.0, 2.0, 9.0]), np.array([0, 2])
    )
    assert found["excess"] == pytest.approx((20 + 0) / 2)
    assert found["gross"] == 0.5
    assert found["nll"] == pytest.approx((np.log(4) + np.log(5 / 4)) / 2)


def test_the_score_of_a_fit_is_found_again_from_its_parts():
    weights = Weights()
    table = table_of(weights)
    np.testing.assert_allclose(choice_model.likelihood_of(table, weights), table["log_likelihood"])
    other = replace(weights, seen=0.6, strain=100.0, held=0.2, paths=3.0)
    expected = weights.score * (fit_of(other).score - 3.0 * 0.02)
    first = table.iloc[:1]
    rest = choice_model.evidence_of(first)[:, 1:] @ [weights.fine_strain, weights.medial, weights.fine_missed]
    np.testing.assert_allclose(choice_model.likelihood_of(first, other), expected + rest)


def test_each_body_is_left_out_once_and_judged_by_weights_of_the_others():
    found = choice_model.left_out(table_of(Weights()), Weights()).set_index(["left out", "weights"])
    assert found.index.tolist() == [(b, w) for b in ("a", "b", "c", "(all)") for w in ("fitted", "shipped")]
    assert found.loc[("a", "shipped"), "fine_strain"] == Weights().fine_strain
    assert (found["pairs"] == [4, 4, 4, 4, 4, 4, 12, 12]).all()
    assert (found.xs("fitted", level="weights")["excess"] == 0).all()


def test_sensitivity_has_each_weight_halved_and_doubled():
    weights = Weights()
    table = table_of(weights)
    found = choice_model.sensitivity(table, weights)
    assert found["weight"].tolist() == ["(as shipped)", *np.repeat(choice_model.TRIED, 2)]
    nll = found.set_index(["weight", "times"])["nll"]
    assert nll["fine_strain", 2.0] < nll["(as shipped)", 1.0] < nll["fine_strain", 0.5]
    assert nll["fine_missed", 2.0] == pytest.approx(nll["(as shipped)", 1.0])  # the same for all


def test_what_quick_fits_foretell_is_recovered_whatever_the_pairs_have_in_common():
    rng = np.random.default_rng(2)
    table = pd.DataFrame({"body": np.repeat(["a", "b"], 40), "pair": np.repeat(["1", "2", "3", "4"], 20)})
    table["regime"], common = "r", np.repeat(rng.normal(0, 50, 4), 20)
    table["score"], table["quick_medial"] = rng.normal(size=(2, 80)) + common
    table["log_likelihood"] = 12 * table["score"] - 30 * table["quick_medial"] + common
    found = choice_model.foretold(table, Weights(quick_score=12.0, quick_medial=0.0))
    np.testing.assert_allclose(found["quick_score"], 12, rtol=1e-6)
    np.testing.assert_allclose(found["quick_medial"], 30, rtol=1e-6)
    np.testing.assert_allclose(found["share"], 1, rtol=1e-6)
    assert (found["share, shipped"] < 0.5).all()


def test_what_none_being_right_depends_on_is_recovered():
    rng = np.random.default_rng(3)
    table = pd.DataFrame({"body": np.repeat(["a", "b"], 2000), "pair": np.arange(4000).astype(str)})
    table["regime"], table["least"] = "r", 2.0
    table["fine_seen"], table["log_likelihood"] = rng.uniform(0, 2, 4000), rng.uniform(-5, 15, 4000)
    odds = table["log_likelihood"] - 1.0 - 4.0 * table["fine_seen"]
    table["error"] = np.where(rng.uniform(size=4000) < 1 / (1 + np.exp(-odds)), 3.0, 30.0)
    found = choice_model.none_right(table, Weights(none=0.0, none_seen=0.0))
    np.testing.assert_allclose(found["none"], 1, atol=0.4)
    np.testing.assert_allclose(found["none_seen"], 4, atol=0.4)
    assert (found["nll"] < found["nll, shipped"]).all()
