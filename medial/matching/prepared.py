"""Two clouds prepared for matching: all that does not depend on which landmarks are tried."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import run_tasks
from datasets_gen.points.farthest import farthest_from_mean
from datasets_gen.values import check_seed
from medial.diffusion import Diffusion
from medial.matching.common_units import (
    MOST_POINTS,
    CloudInUnits,
    check_comparable,
    common_units,
    in_source_units,
)
from medial.matching.config import MatchConfig
from medial.matching.landmarks.descriptors import DiffusionDescriptors, describe
from medial.matching.landmarks.medial_paths import MedialPaths
from medial.matching.landmarks.samples import cluster_samples, spectral_samples
from medial.matching.neighbourhoods import Float32, neighbourhoods
from medial.spectrum.times import logarithmic_times

Int = NDArray[np.int64]

ORDERED = 3000
"""Points of a cover that stand for it alone: no fewer than `refinement.LOOK_BACK` and `direction.BALLS`."""


@dataclass(frozen=True)
class PreparedCloud:
    """One of the two clouds.

    Attributes
    ----------
    descriptors : DiffusionDescriptors
        Its samples, and tables for Eqs. 16 and 17.
    cloud : CloudInUnits
        In the units of the pair: lengths are in sqrt(area).
    paths : MedialPaths, optional
        Where landmark sets by path length are wanted.
    cover : (c,) int64
        What a registration sees of the cloud (`cover_of`).
    coordinates : (n, d) float32, optional
        `medial.matching.neighbourhoods`, where the cloud may be deformed.
    """

    descriptors: DiffusionDescriptors
    cloud: CloudInUnits
    paths: MedialPaths | None
    cover: Int
    coordinates: Float32 | None


@dataclass(frozen=True)
class PreparedPair:
    """The source and the target.

    Attributes
    ----------
    diffusions : (Diffusion, Diffusion)
        In the units of the source.
    source, target : PreparedCloud
    times : (T,) float64
        Shared by both clouds.
    config : MatchConfig
    seed : int
    to_move : (n,) bool, optional
        For a target that is the mirror image of the source, point by point: points that a map may not leave
        in their medial region.
    """

    diffusions: tuple[Diffusion, Diffusion]
    source: PreparedCloud
    target: PreparedCloud
    times: NDArray[np.float64]
    config: MatchConfig
    seed: int
    to_move: NDArray[np.bool_] | None = None


def prepare_pair(
    source: Diffusion,
    target: Diffusion,
    config: MatchConfig | str | None,
    seed: int,
    to_move: NDArray[np.bool_] | None = None,
) -> PreparedPair:
    """Draw samples, tabulate m_t, and bring both clouds to common units.

    Parameters
    ----------
    source, target
        Diffusions of one kind of operator.
    config
        See `MatchConfig.of`.
    seed
        Draws the samples.
    to_move : (n,) bool, optional
        See `PreparedPair`. Maps that leave most of these points in place do not count, if there are others.

    Raises
    ------
    InputError
        If the operators or their settings differ, a cloud has no positive eigenvalue, or the seed is none.
    """
    check_comparable(source, target)
    check_seed(seed)
    config = MatchConfig.of(config, source.departures)
    both = in_source_units(source, target)
    times = logarithmic_times(*(each.eigenvalues for each in both), count=config.times)
    clouds = common_units(*both)
    coordinates: list[Float32 | None] = [None, None]
    if config.selection == "fit" or config.refine == "deform":
        coordinates = [*run_tasks(neighbourhoods, [(each,) for each in both])]
    covers = run_tasks(cover_of, [(cloud.points,) for cloud in clouds])
    samples = _samples(both, coordinates, covers, config, seed)
    own_area = (config.departures or source.departures).area_normalised_kernels
    described = [describe(each, times, some, own_area) for each, some in zip(both, samples, strict=True)]
    paths: list[MedialPaths | None] = [None, None]
    if config.paths and config.selection == "fit":
        paths = [*run_tasks(MedialPaths.of, [(cloud,) for cloud in clouds])]
    first, second = map(PreparedCloud, described, clouds, paths, covers, coordinates)
    return PreparedPair(both, first, second, times, config, seed, to_move)


def cover_of(points: NDArray[np.float64]) -> Int:
    """At most `MOST_POINTS` points of a cloud (n, 3) that cover it, (c,).

    The first are in farthest-point order, of a cloud that is taken as a whole `ORDERED` of them; there the
    order of the others does not count, as long as it does not depend on that of the file.
    """
    if len(points) > MOST_POINTS:
        return farthest_from_mean(points, MOST_POINTS)
    order = farthest_from_mean(points, min(ORDERED, len(points)))
    outermost = np.argsort(-np.linalg.norm(points - points.mean(axis=0), axis=1), kind="stable")
    rest = np.ones(len(points), dtype=bool)
    rest[order] = False
    return np.concatenate([order, outermost[rest[outermost]]])


def _samples(
    diffusions: tuple[Diffusion, Diffusion],
    coordinates: list[Float32 | None],
    covers: list[Int],
    config: MatchConfig,
    seed: int,
) -> list[Int]:
    """S_P and S_Q: by spectral clustering (Sec. 4); where the fit decides, they cover the surface."""
    rngs = [np.random.default_rng([seed, k]) for k in (0, 1)]
    if config.selection == "fit":
        each = zip(coordinates, covers, rngs, strict=True)
        return run_tasks(_of_cover, [(x, cover, config.samples, rng) for x, cover, rng in each])
    return [spectral_samples(d, config.samples, rng) for d, rng in zip(diffusions, rngs, strict=True)]


def _of_cover(coordinates: Float32, cover: Int, count: int, rng: np.random.Generator) -> Int:
    """`cluster_samples` of the points that a registration sees: the time does not grow with the others."""
    seen = np.sort(cover)
    return seen[cluster_samples(coordinates[seen], count, rng)]
