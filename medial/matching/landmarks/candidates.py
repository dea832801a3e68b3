"""Candidate maps: landmark sets of the diffusion (Eq. 16) and of medial path length, and their maps."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import run_tasks
from datasets_gen.points.farthest import farthest_in_embedding
from medial.matching.config import MatchConfig
from medial.matching.landmarks.descriptors import DiffusionDescriptors, middle_time
from medial.matching.landmarks.diffusion_landmarks import first_partners, landmark_order, search_landmarks
from medial.matching.landmarks.extrapolation import extrapolate_landmarks
from medial.matching.landmarks.medial_paths import MedialPaths
from medial.matching.landmarks.path_landmarks import NONE, LandmarkSet, extrapolate_by_paths, landmark_sets
from medial.matching.landmarks.samples import diffusion_map

Int = NDArray[np.int64]


@dataclass(frozen=True)
class Candidate:
    """One landmark set and the map that is extrapolated from it.

    Attributes
    ----------
    landmarks : (L, 2) int64
        Source and target point ids.
    cost : float
        Mean of Eq. 17 over the samples; NaN for sets found by path length.
    by_paths : bool
        Found by path length instead of Eq. 16.
    at_samples : (s,) int64
        Target points of the source samples.
    dense : callable
        Target points of all source points.
    backward : bool
        Tried by deforming the target of the pair onto its source: the map goes that way, while `landmarks`
        stay source and target of the pair.
    """

    landmarks: Int
    cost: float
    by_paths: bool
    at_samples: Int
    dense: Callable[[], Int]
    backward: bool = False


def diffusion_sets(
    here: DiffusionDescriptors,
    there: DiffusionDescriptors,
    times: NDArray[np.float64],
    config: MatchConfig,
    starts: Int,
) -> list[Int]:
    """Landmark sets from first landmarks and each of their partners (Eq. 16), (L, 2) point ids each."""
    middle = middle_time(times)

    def from_start(start: int) -> list[Int]:
        order = landmark_order(here, times, start, config.landmarks)
        if config.partners == 1:
            sets = [search_landmarks(here, there, order, config)]
        else:
            firsts = first_partners(here, there, start, config, middle)
            sets = [search_landmarks(here, there, order, config, int(first)) for first in firsts]
        return [np.column_stack([here.samples[order], there.samples[partners]]) for partners in sets]

    return [one for found in run_tasks(from_start, [(int(start),) for start in starts]) for one in found]


def first_landmarks(
    here: DiffusionDescriptors, time: float, config: MatchConfig, rng: np.random.Generator
) -> Int:
    """Positions of first landmarks in the samples: at random as in Sec. 4, or far apart."""
    count = min(config.restarts, len(here.samples))
    if config.starts == "random":
        return rng.choice(len(here.samples), size=count, replace=False)
    embedding = diffusion_map(here.diffusion, time, here.samples)
    remote = int(np.linalg.norm(embedding - embedding.mean(axis=0), axis=1).argmax())
    return farthest_in_embedding(embedding, count, remote)


def diffusion_candidate(
    here: DiffusionDescriptors, there: DiffusionDescriptors, landmarks: Int, config: MatchConfig
) -> Candidate:
    """The candidate that Eq. 17 makes of landmarks; where the fit decides, samples map to samples."""
    among = there.samples if config.selection == "fit" else None
    at_samples, residual = extrapolate_landmarks(here, there, landmarks, here.samples, among)
    return Candidate(
        landmarks,
        float(residual.mean()),
        False,
        at_samples,
        lambda: extrapolate_landmarks(here, there, landmarks, slice(None))[0],
    )


def path_sets(source: MedialPaths, target: MedialPaths) -> list[LandmarkSet]:
    """Landmark sets that agree in medial path length; node numbers, no landmark without partner."""
    known = ((found, found.target != NONE) for found in landmark_sets(source, target))
    return [LandmarkSet(s.source[some], s.target[some], s.cost) for s, some in known if some.any()]


def path_candidate(
    here: DiffusionDescriptors, source: MedialPaths, target: MedialPaths, landmarks: LandmarkSet
) -> Candidate:
    """The candidate that path lengths make of landmarks."""
    node = extrapolate_by_paths(source, target, landmarks.source, landmarks.target)
    dense = target.nodes[node][source.nearest]
    pairs = np.column_stack([source.nodes[landmarks.source], target.nodes[landmarks.target]])
    return Candidate(pairs, float("nan"), True, dense[here.samples], lambda: dense)
