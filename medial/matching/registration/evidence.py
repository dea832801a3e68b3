"""What speaks for a map, in one sum: the log-likelihood of a fit against its rivals.

Each kind of evidence enters with one weight. `tests.benchmarks.match_evidence` estimates the weights of the
finely settled fit by conditional logistic regression [McF74]: over the fits that the search found for a pair,
the probability that a fit is a right one is the share of its exp(log-likelihood).

References
----------
[McF74] McFadden: Conditional logit analysis of qualitative choice behavior. Frontiers in Econometrics, 1974.
"""

from collections.abc import Collection
from dataclasses import dataclass, replace
from typing import Literal, get_args

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

Float = NDArray[np.float64]
Kind = Literal["visibility", "strain", "paths", "medial"]
KINDS: tuple[Kind, ...] = get_args(Kind)


@dataclass(frozen=True, kw_only=True)
class Weights:
    """Weights of the evidence. Lengths are in sqrt(area), areas in the area.

    The first five make the score, by which the search compares quick fits; the others turn it into a
    log-likelihood once a fit is settled finely.
    """

    seen: float = 0.3
    """Worth of surface that meets, relative to the cost of surface that should have met and does not."""
    strain: float = 600.0
    """Cost of the mean square strain. Strain tells half a turn about the long axis from the right map."""
    held: float = 0.75
    """Worth of the share of the body that holds together."""
    paths: float = 6.0
    """Cost of the mean change of path lengths along the body. A shank on the other leg's knee fits as well as
    on its own, but is elsewhere along the body."""
    mirrored_paths: float = 10.0
    """The same between a cloud and its mirror image, which have the same gaps."""
    score: float = 10.0
    """Log-likelihood of a unit of score."""
    fine_strain: float = 9000.0
    """Of the mean square strain of the finely settled fit."""
    medial: float = 40.0
    """Of the distance between medial balls (`medial_gap`)."""
    fine_missed: float = 2.0
    """Of the surface that the finely settled fit misses."""
    quick_score: float = 17.0
    """Log-likelihood that a unit of score foretells before a fit is settled finely, by least squares."""
    quick_medial: float = 25.0
    """The same of the distance between the medial balls of the quick fit, which is larger."""
    none: float = -3.0
    """Log-likelihood of no map of those found being right, where no surface meets."""
    none_seen: float = 7.0
    """The same for a unit of surface that meets (`Fit.seen`) under the most likely map: a right one strains
    little where much meets."""

    @classmethod
    def of(cls, kinds: Collection[Kind]) -> "Weights":
        """The weights of some kinds of evidence; those of the others are 0.

        Visibility has no weight: without it each scan is taken to show everything.
        """
        weights = cls()
        if "strain" not in kinds:
            weights = replace(weights, strain=0.0, held=0.0, fine_strain=0.0)
        if "paths" not in kinds:
            weights = replace(weights, paths=0.0, mirrored_paths=0.0)
        return weights if "medial" in kinds else replace(weights, medial=0.0, quick_medial=0.0)


WEIGHTS = Weights()


def log_likelihood(
    weights: Weights, score: float, fine_strain: float, medial: float, fine_missed: float
) -> float:
    """Log-likelihood of a finely settled fit, up to what all fits of a pair have in common.

    Parameters
    ----------
    weights
    score
        Of the quick fit (`Placement.score`).
    fine_strain, fine_missed
        `Fit.strain` and `Fit.missed` of the finely settled fit.
    medial
        `medial_gap` of the finely settled fit.
    """
    return (
        weights.score * score
        - weights.fine_strain * fine_strain
        - weights.medial * medial
        - weights.fine_missed * fine_missed
    )


def promise(weights: Weights, score: float, medial: float) -> float:
    """What a quick fit foretells of the log-likelihood, up to what all fits of a pair have in common.

    Parameters
    ----------
    weights
    score
        `Placement.score`.
    medial
        `medial_gap` of the quick fit.
    """
    return weights.quick_score * score - weights.quick_medial * medial


def medial_gap(centers: Float, radii: Float, other_centers: Float, other_radii: Float) -> float:
    """How far two sets of medial balls are apart, in their unit of length.

    A limb has its medial balls from whichever side it was scanned, so they meet where the surfaces do not.

    Parameters
    ----------
    centers : (n, 3)
    radii : (n,)
    other_centers : (m, 3)
    other_radii : (m,)

    Returns
    -------
    float
        Mean distance of each ball to the nearest one of the other set, in centre and radius, plus the same
        the other way; 0 for surface operators, whose balls have no radius.
    """
    if not radii.any() or not other_radii.any():
        return 0.0
    here, there = np.column_stack([centers, radii]), np.column_stack([other_centers, other_radii])
    return float(cKDTree(there).query(here)[0].mean() + cKDTree(here).query(there)[0].mean())


def likelihood_of_none(weights: Weights, seen: float) -> float:
    """Log-likelihood of no map of those found being right.

    Parameters
    ----------
    weights
    seen
        `Fit.seen` of the most likely one, finely settled.
    """
    return weights.none + weights.none_seen * seen


def likelihood_of_other_limbs(none: float, best: float) -> float:
    """Log-likelihood of no map being right where the clouds show one side each, and not the same one.

    What one view shows of a limb fits the limb of the other side as well, and no view shows the rest: besides
    `likelihood_of_none`, a map with the limbs of the other side is as likely as the best one that was found.

    Parameters
    ----------
    none
        `likelihood_of_none`.
    best
        Log-likelihood of the most likely map.
    """
    return float(np.logaddexp(none, best))


def probabilities(log_likelihoods: Float, none: float) -> Float:
    """Probability of each map, (n,): its share of all exp(log-likelihood), with that of none being right."""
    rivals = np.append(log_likelihoods, none)
    odds = np.exp(rivals - rivals.max())
    return np.asarray(odds[:-1] / odds.sum())
