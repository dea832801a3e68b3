"""Conditional logit over finalists [McF74]: likelihood of a right choice, weights, and what they choose.

A table has one row per finalist; those of one pair of scans are a choice set (`SET`) and lie together.

References
----------
[McF74] McFadden: Conditional logit analysis of qualitative choice behavior. Frontiers in Econometrics, 1974.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.optimize import minimize

from evaluation.metrics.correspondence import GROSS_ERROR
from medial.matching.registration.evidence import Weights, log_likelihood

Float = NDArray[np.float64]
Int = NDArray[np.int64]
Bool = NDArray[np.bool_]

SET = ["body", "pair", "regime"]
"""Columns that name a choice set."""
SIGNS = {"score": 1.0, "fine_strain": -1.0, "medial": -1.0, "fine_missed": -1.0}
"""Columns of the evidence, called like their `Weights`, and whether they speak for a map or against it."""
RIGHT = (1.25, 0.75)
"""A finalist is right up to this factor of the least error of its set, plus this; x 100 / sqrt(area)."""
RIDGE = 0.003
"""Cost of the squared weights of standardised evidence: pairs without doubt would make them infinite."""
WITHIN = 5.0
"""A map is right whose error is within this of the least one that any map can have; x 100 / sqrt(area)."""
TRIED = ("score", "fine_strain", "medial", "fine_missed", "seen", "strain", "held", "paths")
"""Weights that `sensitivity` halves and doubles."""


def starts_of(table: pd.DataFrame) -> Int:
    """Row at which each choice set starts."""
    return np.flatnonzero((table[SET] != table[SET].shift()).any(axis=1))


def evidence_of(table: pd.DataFrame) -> Float:
    """The columns of `SIGNS` with their signs, (n, 4): their weights are positive."""
    return table[list(SIGNS)].to_numpy(np.float64) * np.array(list(SIGNS.values()))


def right_ones(error: Float, starts: Int) -> Bool:
    """Finalists with nearly the least error of their set (`RIGHT`), (n,)."""
    least = _of_rows(np.minimum.reduceat(error, starts), starts, len(error))
    return np.asarray(error <= RIGHT[0] * least + RIGHT[1])


def loss(likelihood: Float, starts: Int, right: Bool) -> float:
    """Mean of -log(sum of exp over the right ones / sum of exp over all) of the choice sets.

    Parameters
    ----------
    likelihood : (n,)
        Log-likelihood of each finalist, up to a constant of its set.
    starts : (k,)
    right : (n,)
    """
    every = np.logaddexp.reduceat(likelihood, starts)
    good = np.logaddexp.reduceat(np.where(right, likelihood, -np.inf), starts)
    return float((every - good).mean())


def fit(evidence: Float, starts: Int, right: Bool, ridge: float = RIDGE) -> Float:
    """The weights of least `loss`, (d,).

    Parameters
    ----------
    evidence : (n, d)
    starts, right
        As for `loss`.
    ridge
        As `RIDGE`; evidence is standardised by how much it differs within choice sets.
    """
    sizes = np.diff(np.append(starts, len(evidence)))
    means = np.add.reduceat(evidence, starts) / sizes[:, None]
    apart = evidence - _of_rows(means, starts, len(evidence))
    scale = apart.std(axis=0)
    differs = scale > 1e-12 * np.abs(evidence).max(axis=0, initial=0.0)
    scale = np.where(differs, scale, np.inf)  # what never differs weighs nothing
    standard = apart / scale

    def cost(weights: Float) -> float:
        return loss(standard @ weights, starts, right) + ridge * float(weights @ weights)

    return np.asarray(minimize(cost, np.ones(evidence.shape[1])).x / scale)


def judge(likelihood: Float, error: Float, starts: Int) -> dict[str, float]:
    """What comes of choosing the most likely finalist of each set.

    Returns
    -------
    dict
        ``nll`` (`loss`), ``excess`` (mean of its error less the least one of the set), ``gross`` (share of
        sets in which its error is above `GROSS_ERROR`).
    """
    ends = np.append(starts[1:], len(error))
    chosen = np.array([a + int(likelihood[a:b].argmax()) for a, b in zip(starts, ends, strict=True)])
    least = np.minimum.reduceat(error, starts)
    return {
        "nll": loss(likelihood, starts, right_ones(error, starts)),
        "excess": float((error[chosen] - least).mean()),
        "gross": float((error[chosen] > 100 * GROSS_ERROR).mean()),
    }


def likelihood_of(table: pd.DataFrame, weights: Weights) -> Float:
    """Log-likelihood of every finalist had its fits been compared with other weights, (n,).

    The finalists stay what they are: the search is not done again.
    """
    meets = weights.seen * table["seen"] + 2 - table["missed"]
    held, strain, paths = table["held"], table["strain"], table["paths"]
    score = meets / (1 + weights.seen) + weights.held * held - weights.strain * strain - weights.paths * paths
    rest = (table[name].to_numpy(np.float64) for name in ("fine_strain", "medial", "fine_missed"))
    return np.asarray(log_likelihood(weights, score.to_numpy(np.float64), *rest))


def sensitivity(table: pd.DataFrame, weights: Weights) -> pd.DataFrame:
    """`judge` with each weight (`TRIED`) halved and doubled, after that of the weights as they are."""
    error, starts = table["error"].to_numpy(np.float64), starts_of(table)
    cases = [("(as shipped)", 1.0, weights)]
    for name in TRIED:
        value = getattr(weights, name)
        cases += [(name, by, replace(weights, **{name: by * value})) for by in (0.5, 2.0)]
    rows = [
        {"weight": name, "times": by} | judge(likelihood_of(table, each), error, starts)
        for name, by, each in cases
    ]
    return pd.DataFrame(rows)


def foretold(table: pd.DataFrame, weights: Weights) -> pd.DataFrame:
    """For each body: what quick fits of the others foretell of the log-likelihood, and how well on that body.

    By least squares within choice sets. `share` is the share of the variance within them that is foretold, by
    the fitted and by the given weights.
    """
    columns = ["log_likelihood", "score", "quick_medial"]
    apart = table[columns] - table.groupby(SET)[columns].transform("mean")
    given = np.array([weights.quick_score, -weights.quick_medial])
    rows = []
    for body, there, rest in _bodies(table):
        likelihood, quick = (apart[names].to_numpy(np.float64) for names in (columns[0], columns[1:]))
        fitted = np.linalg.lstsq(quick[rest], likelihood[rest], rcond=None)[0]
        shares = [_explained(likelihood[there], quick[there] @ each) for each in (fitted, given)]
        named = {"quick_score": fitted[0], "quick_medial": -fitted[1]}
        rows.append({"left out": body} | named | dict(zip(("share", "share, shipped"), shares, strict=True)))
    return pd.DataFrame(rows)


def none_right(table: pd.DataFrame, weights: Weights) -> pd.DataFrame:
    """For each body: `Weights.none` and `none_seen` fitted to the others, and how well they foretell on it.

    A choice set counts as right if its most likely finalist is within `WITHIN` of the least error of any map
    of the pair. `nll` is the mean of -log(probability of what is the case); `share` is the share of
    sets that are right.
    """
    chosen = table.loc[table.groupby(SET, sort=False)["log_likelihood"].idxmax()]
    right = (chosen["error"] < chosen["least"] + WITHIN).to_numpy()
    likelihood, seen = (chosen[name].to_numpy(np.float64) for name in ("log_likelihood", "fine_seen"))

    def cost(none: Float, sets: Bool) -> float:
        odds = likelihood[sets] - none[0] - none[1] * seen[sets]
        return float(np.logaddexp(0, np.where(right[sets], -odds, odds)).mean())

    given = np.array([weights.none, weights.none_seen])
    rows = []
    for body, there, rest in _bodies(chosen):
        fitted = minimize(cost, given, args=(rest,), method="Nelder-Mead").x
        named = {"none": fitted[0], "none_seen": fitted[1], "share": right[there].mean()}
        rows.append(
            {"left out": body} | named | {"nll": cost(fitted, there), "nll, shipped": cost(given, there)}
        )
    return pd.DataFrame(rows)


def _bodies(table: pd.DataFrame) -> Iterator[tuple[str, Bool, Bool]]:
    """Each body, its rows and those of the others; then all bodies, judged on the rows they are fitted to."""
    for body in table["body"].unique():
        there = (table["body"] == body).to_numpy()
        yield body, there, there if there.all() else ~there
    every = np.ones(len(table), dtype=bool)
    yield "(all)", every, every


def _explained(values: Float, foretold_values: Float) -> float:
    return 1 - float(((values - foretold_values) ** 2).sum() / (values**2).sum())


def left_out(table: pd.DataFrame, weights: Weights) -> pd.DataFrame:
    """For each body: weights fitted to the others, what they choose on it, and what given weights choose.

    The last row of each kind is of all bodies: fitted to and judged on the same sets.
    """
    given = np.array([getattr(weights, name) for name in SIGNS])
    rows = []
    for body, there, others in _bodies(table):
        rest = table[others]
        starts = starts_of(rest)
        right = right_ones(rest["error"].to_numpy(np.float64), starts)
        fitted = fit(evidence_of(rest), starts, right)
        on = table[there]
        starts, error = starts_of(on), on["error"].to_numpy(np.float64)
        for kind, each in (("fitted", fitted), ("shipped", given)):
            figures = judge(evidence_of(on) @ each, error, starts)
            named = dict(zip(SIGNS, each.tolist(), strict=True))
            rows.append({"left out": body, "weights": kind, **named, "pairs": len(starts), **figures})
    return pd.DataFrame(rows)


def _of_rows(values: Float, starts: Int, count: int) -> Float:
    """Values of choice sets at each of their rows."""
    return np.repeat(values, np.diff(np.append(starts, count)), axis=0)
