"""Which candidates are tried, in which direction: a first batch for every pair, and a second for hard ones.

A landmark set holds points of the pair's source and target, whichever direction found it and whichever
direction tries it.
"""

from dataclasses import replace

import numpy as np

from datasets_gen.compiled import run_tasks
from medial.matching.common_units import Int
from medial.matching.landmarks.candidates import (
    Candidate,
    diffusion_candidate,
    diffusion_sets,
    first_landmarks,
    path_candidate,
    path_sets,
)
from medial.matching.landmarks.descriptors import middle_time
from medial.matching.landmarks.path_landmarks import LandmarkSet
from medial.matching.registration.direction import Direction


def first_landmarks_of(directions: list[Direction]) -> list[Int]:
    """First landmarks of each direction: positions in the samples of the cloud it deforms, (restarts,)."""
    pair = directions[0].pair
    time = middle_time(pair.times)
    rngs = [np.random.default_rng([pair.seed, 2 + each.backward]) for each in directions]
    return [
        first_landmarks(each.source.descriptors, time, pair.config, rng)
        for each, rng in zip(directions, rngs, strict=True)
    ]


def first_batch(directions: list[Direction], starts: list[Int]) -> list[Candidate]:
    """Candidates for every pair: each set is tried in every direction.

    The sets grow from the first half of each direction's first landmarks, or from all of them where there is
    one direction, and from path lengths.
    """
    half = _first_part(directions, starts)
    each = zip(directions, starts, strict=True)
    sets = [pairs for direction, some in each for pairs in sets_by_diffusion(direction, some[:half])]
    by_paths = sets_by_paths(directions[0])
    return [c for direction in directions for c in candidates(direction, sets, by_paths)]


def second_batch(directions: list[Direction], starts: list[Int]) -> list[Candidate]:
    """Further candidates: each direction tries its own sets alone.

    They grow from the other half of the first landmarks, and, for the opposite direction, from path lengths
    searched from the target. With one direction there are none.
    """
    half = _first_part(directions, starts)
    found = []
    for direction, some in zip(directions, starts, strict=True):
        by_paths = sets_by_paths(direction) if direction.backward else []
        found += candidates(direction, sets_by_diffusion(direction, some[half:]), by_paths)
    return found


def _first_part(directions: list[Direction], starts: list[Int]) -> int:
    """How many of the first landmarks of each direction the first batch takes."""
    return -(-len(starts[0]) // len(directions))


def sets_by_diffusion(direction: Direction, starts: Int) -> list[Int]:
    """Landmark sets by Eq. 16 from first landmarks: (L, 2) source and target points of the pair each.

    None where Eq. 16 is not asked (`MatchConfig.by_diffusion`).
    """
    if not direction.pair.config.by_diffusion:
        return []
    here, there, pair = direction.source.descriptors, direction.target.descriptors, direction.pair
    return [_reversed(direction, s) for s in diffusion_sets(here, there, pair.times, pair.config, starts)]


def sets_by_paths(direction: Direction) -> list[LandmarkSet]:
    """Landmark sets that agree in path length, where those are wanted: source and target of the pair."""
    here, there = direction.source.paths, direction.target.paths
    if here is None or there is None:
        return []
    return [_reversed_set(direction, each) for each in path_sets(here, there)]


def candidates(direction: Direction, sets: list[Int], by_paths: list[LandmarkSet]) -> list[Candidate]:
    """The candidates that landmark sets of the pair make in a direction; their maps are of its source.

    Parameters
    ----------
    direction
    sets : list of (L, 2) int64
        Point ids.
    by_paths
        Node numbers of `MedialPaths`.
    """
    here, there, config = direction.source, direction.target, direction.pair.config

    def by_diffusion(pairs: Int) -> Candidate:
        return diffusion_candidate(here.descriptors, there.descriptors, _reversed(direction, pairs), config)

    def by_length(landmarks: LandmarkSet) -> Candidate:
        assert here.paths is not None
        assert there.paths is not None
        return path_candidate(here.descriptors, here.paths, there.paths, _reversed_set(direction, landmarks))

    found = run_tasks(by_diffusion, [(s,) for s in sets]) + run_tasks(by_length, [(s,) for s in by_paths])
    return [
        replace(c, landmarks=_reversed(direction, c.landmarks), backward=direction.backward) for c in found
    ]


def _reversed(direction: Direction, landmarks: Int) -> Int:
    """Landmarks (L, 2) of the pair as source and target of a direction, or the other way round."""
    return landmarks[:, ::-1] if direction.backward else landmarks


def _reversed_set(direction: Direction, each: LandmarkSet) -> LandmarkSet:
    return LandmarkSet(each.target, each.source, each.cost) if direction.backward else each
