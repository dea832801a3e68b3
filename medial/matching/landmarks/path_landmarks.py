"""Landmark sets that agree in medial path length: every consistent one, the mirrored ones among them."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from datasets_gen.compiled import compiled
from medial.matching.common_units import Float, Int
from medial.matching.landmarks.medial_paths import MedialPaths

NONE = -1
"""Partner of a landmark that has no counterpart."""
SEEN_SCALE = 0.12  # difference of descriptors that costs 1
PARTNERS = 260  # target nodes considered
CONSIDERED = 2000  # extensions looked at per step, cheapest first


@dataclass(frozen=True, kw_only=True)
class SearchConfig:
    """Settings of `landmark_sets`. Lengths are in square roots of the surface area."""

    landmarks: int = 9
    """Landmarks on the source, farthest points of the path lengths: the tips of the limbs first."""
    width: int = 150
    """Partial sets kept from step to step."""
    tolerance: float = 0.06
    """Difference of two path lengths that costs 1, for short paths; 5 % of the length is added."""
    apart: float = 0.12
    """Sets all of whose partners are this close are one set."""
    missing: float = 2.5
    """Cost of a landmark without counterpart."""
    sets: int = 24
    """Sets returned."""


@dataclass(frozen=True)
class LandmarkSet:
    """Landmarks and partners (node numbers; partners may be `NONE`), and how much they disagree."""

    source: Int
    target: Int
    cost: float


def landmark_sets(
    source: MedialPaths, target: MedialPaths, config: SearchConfig | None = None
) -> list[LandmarkSet]:
    """Search the consistent landmark sets with a beam.

    A partner costs its difference in what it sees, plus, averaged over the landmarks before it, the squared
    difference of path lengths. Near-duplicates are merged at every step, so that the beam keeps the
    alternatives: left for right, arm for leg.

    Returns
    -------
    list of LandmarkSet
        Cheapest first, at most `config.sets`.
    """
    config = config or SearchConfig()
    here, there = source.far_apart(config.landmarks), target.far_apart(PARTNERS)
    seen = np.abs(source.descriptors()[here][:, None] - target.descriptors()[there][None])
    unary = (np.minimum(seen / SEEN_SCALE, 2) ** 2).mean(axis=-1)  # (L, Q)
    between = target.lengths[np.ix_(there, there)]
    apart = np.pad(between, ((0, 1), (0, 1)), constant_values=np.inf)  # NONE indexes the last row
    apart[-1, -1] = 0
    states, costs = np.empty((1, 0), dtype=np.int64), np.zeros(1)
    for step in range(len(here)):
        total = costs[:, None] + unary[step]
        for earlier in range(step):
            length = source.lengths[here[step], here[earlier]]
            partner = states[:, earlier]
            ratio = np.abs(between[partner] - length) / (config.tolerance + 0.05 * length)
            total += np.where((partner != NONE)[:, None], np.minimum(ratio, 3) ** 2 / step, 0)
        total = np.column_stack([total, costs + config.missing])
        cheapest = np.argsort(total, axis=None, kind="stable")[:CONSIDERED]
        state, partner = np.divmod(cheapest, len(there) + 1)
        partner = np.where(partner == len(there), NONE, partner)
        grown = np.column_stack([states[state], partner])
        kept = distinct_states(grown, apart, config.apart, config.width)
        states, costs = grown[kept], total.ravel()[cheapest[kept]]
    return [
        LandmarkSet(here, np.where(state == NONE, NONE, there[state]), float(cost))
        for state, cost in zip(states[: config.sets], costs, strict=False)
    ]


@compiled()
def distinct_states(states: Int, apart: Float, least: float, most: int) -> Int:
    """Positions of states (n, L), cheapest first, of which no two have all partners closer than `least`.

    Each is the first that is not close to one before it; at most `most`. Partners index `apart`, negative
    ones from its end.
    """
    kept = np.empty(most, np.int64)
    count = 0
    for k in range(len(states)):
        new = True
        for e in range(count):
            new = False
            for column in range(states.shape[1]):
                new |= apart[states[k, column], states[kept[e], column]] >= least
            if not new:
                break
        if new:
            kept[count] = k
            count += 1
            if count == most:
                break
    return kept[:count]


def extrapolate_by_paths(source: MedialPaths, target: MedialPaths, landmarks: Int, partners: Int) -> Int:
    """Target node of every source node by its path lengths to the landmarks, and its radius.

    Parameters
    ----------
    source, target
    landmarks, partners : (L,) int64
        Node numbers; landmarks without counterpart do not count.

    Returns
    -------
    (K_source,) int64
    """
    known = partners != NONE
    here = np.column_stack([source.lengths[:, landmarks[known]], source.radii])
    there = np.column_stack([target.lengths[:, partners[known]], target.radii])
    return cKDTree(there).query(here, p=1)[1].astype(np.int64)
