"""Matching that holds when much is missing: landmark sets by path length, judged by deformation.

1. Landmark sets whose medial path lengths agree are searched (`medial.candidates`); mirrored and
   half-mirrored sets agree as well, so all are kept.
2. Each is spread to a map between medial regions and tried out by a quick registration; the one whose
   surfaces find each other with the least strain is taken.
3. It is registered finely. Then the points that found their counterpart serve as landmarks for those that did
   not, as long as the registration gets better.
4. The target point nearest to a deformed source point, in position and normal, is its match.
"""

from dataclasses import dataclass

import numpy as np

from datasets_gen.records import InputError
from medial.candidates import LandmarkSet, SearchConfig, landmark_sets, spread
from medial.cloud import Cloud, Float, Int, common_units
from medial.compiled import run_tasks
from medial.diffusion import Diffusion
from medial.paths import MedialPaths
from medial.registration import Fit, Registration, RegistrationConfig

UNDECIDED = 0.03
"""Scores of a map and of its rival that differ less leave it open which is right."""
RIVAL = 0.1
"""Mean distance, in square roots of area, from which two maps count as different."""
REPAIRS = 2
FINALISTS = 8
"""Candidates registered to the end."""
ANCHORS = 40


@dataclass(frozen=True)
class Trial:
    """One candidate: its landmarks, how it fared, whether to the last round, and the map it came to."""

    landmarks: LandmarkSet
    fit: Fit
    finished: bool
    source_to_target: Int


@dataclass(frozen=True)
class Outcome:
    """Result of `match_by_deformation`; see `medial.Matching` for the fields it becomes."""

    source_to_target: Int
    confidence: Float
    landmarks: Int
    trials: list[Trial]
    fit: Fit
    flip: str


def match_by_deformation(source: Diffusion, target: Diffusion, search: SearchConfig | None = None) -> Outcome:
    """Match two clouds.

    Parameters
    ----------
    source, target
        Diffusions of one kind of operator; medial centres and radii are used where it has them.
    search
        Settings of the landmark search.

    Raises
    ------
    InputError
        If a cloud is too small to carry a deformation.
    """
    here, there = common_units(source, target)
    for cloud, name in ((here, "source"), (there, "target")):
        if len(cloud) < 50:
            raise InputError(f"the {name} has {len(cloud)} points; matching by deformation needs 50 or more")
    paths_here, paths_there = MedialPaths.of(here), MedialPaths.of(there)
    quick = Registration(here, there, RegistrationConfig.coarse())
    trials = _trials(quick, paths_here, paths_there, landmark_sets(paths_here, paths_there, search))
    best = max((trial for trial in trials if trial.finished), key=lambda trial: trial.fit.score)
    fine = Registration(here, there)
    fit = fine.settle(fine.adopt(quick, best.fit.pose))
    fit = _repair(fine, fit, paths_here, paths_there)
    mapped, distance, agreement = fine.correspondence(fit.pose)
    known = best.landmarks.target >= 0
    landmarks = paths_here.nodes[best.landmarks.source[known]]
    return Outcome(
        source_to_target=mapped,
        confidence=_confidence(distance, agreement, fine, fit),
        landmarks=np.column_stack([landmarks, mapped[landmarks]]),
        trials=trials,
        fit=fit,
        flip=flip_verdict(trials, best, there),
    )


def _trials(
    registration: Registration, source: MedialPaths, target: MedialPaths, sets: list[LandmarkSet]
) -> list[Trial]:
    """Register every landmark set for a few rounds, the best of them to the end."""
    early = registration.config.rounds // 3

    def begin(landmarks: LandmarkSet) -> Fit:
        node = spread(source, target, landmarks.source, landmarks.target)
        pose = registration.follow(target.nodes[node][source.nearest])
        return registration.settle(pose, last=early)

    begun = run_tasks(begin, [(each,) for each in sets])
    order = np.argsort([-fit.score for fit in begun], kind="stable")[:FINALISTS]
    done = run_tasks(lambda fit: registration.settle(fit.pose, first=early), [(begun[k],) for k in order])
    fits = dict(zip(order.tolist(), done, strict=True))
    return [
        Trial(landmarks, fits.get(k, fit), k in fits, registration.correspondence(fits.get(k, fit).pose)[0])
        for k, (landmarks, fit) in enumerate(zip(sets, begun, strict=True))
    ]


def _repair(registration: Registration, fit: Fit, source: MedialPaths, target: MedialPaths) -> Fit:
    """Map what found no counterpart by its paths to what did, and settle again; keep improvements."""
    for _ in range(REPAIRS):
        mapped, distance, agreement = registration.correspondence(fit.pose)
        found = (distance < registration.config.reach[1]) & (agreement > 0.5)
        sure = np.flatnonzero(found[source.nodes])
        if not 10 <= len(sure) < len(source.nodes):
            return fit
        anchors = sure[:ANCHORS]  # nodes are in farthest-point order
        partners = target.nearest[mapped[source.nodes[anchors]]]
        node = spread(source, target, anchors, partners)
        remapped = np.where(found, mapped, target.nodes[node][source.nearest])
        better = registration.settle(registration.follow(remapped))
        if better.score <= fit.score:
            return fit
        fit = better
    return fit


def _confidence(distance: Float, agreement: Float, registration: Registration, fit: Fit) -> Float:
    """Belief that a match is right: the deformed point met its match, and the map as a whole held."""
    reach = registration.config.reach[1]
    met = np.clip(agreement, 0, 1) / (1 + (distance / reach) ** 2)
    return met * np.clip((fit.source_coverage + fit.target_coverage) / 1.2, 0, 1)


def flip_verdict(trials: list[Trial], best: Trial, target: Cloud) -> str:
    """Whether the taken map is the one that path lengths alone prefer, a rival of it, or hardly better.

    Returns
    -------
    {"kept", "flipped", "undecided"}
    """

    def differ(a: Trial, b: Trial) -> bool:
        gap = target.points[a.source_to_target] - target.points[b.source_to_target]
        return bool(np.linalg.norm(gap, axis=1).mean() > RIVAL)

    rivals = [trial for trial in trials if differ(trial, best)]
    if any(rival.fit.score > best.fit.score - UNDECIDED for rival in rivals):
        return "undecided"
    return "flipped" if differ(trials[0], best) else "kept"
