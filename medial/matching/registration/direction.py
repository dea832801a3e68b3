"""The two ways to match a pair: deform the source onto the target, or the target onto the source.

Where both clouds are partial, one of the two is often the easier problem: a limb that is there finds its way
onto a body more easily than a body with a hole finds a limb. Each way therefore starts from its own
candidates, the settled maps of one are handed to the other turned round, and what fits best in the end wins.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import run_tasks
from medial.matching.common_units import Cloud, Int
from medial.matching.config import MatchConfig
from medial.matching.landmarks.candidates import (
    Candidate,
    diffusion_sets,
    first_landmarks,
    grown,
    grown_by_paths,
    path_sets,
)
from medial.matching.landmarks.diffusion_landmarks import Side, middle_time
from medial.matching.landmarks.medial_paths import MedialPaths, path_distortion
from medial.matching.landmarks.path_landmarks import LandmarkSet
from medial.matching.landmarks.rigid_starts import rigid_poses
from medial.matching.registration.deformation_graph import Float32, NodeGraph, Pose
from medial.matching.registration.exchange import Exchange, distinct, recombine
from medial.matching.registration.refinement import FineDeformation
from medial.matching.registration.registration import Fit, Registration, Schedule, features, nearest_places

QUICK = Schedule()
LIKE = 0.02
"""Maps that put the points closer together than this, in sqrt(area), before they settle count as one."""
EARLY = 5
"""Rounds of closest points before like fits are merged again and the worst are dropped."""
PROMISING = 12
"""Distinct fits of a way that are settled to the end."""
ANEW = 6
"""Of those, distinct ones that are settled anew with each of `STIFF`."""
STIFF = tuple(Schedule(stiffness=(first, 0.01)) for first in (100.0, 300.0))
"""Nearly rigid at first: a limb that went astray is pulled back by what it hangs on, and looks again."""
RIGID = Schedule(rounds=25, stiffness=(1000.0, 0.01), reach=(0.25, 0.03))
"""From rigid motions: stiffer, and looking further, as nothing is in place yet."""
RIGID_EARLY, RIGID_KEPT = 8, 6
"""Rounds of `RIGID` after which only so many distinct fits go on."""
HANDED_OVER = 8
"""Fits that each way hands to the other, before and after parts are exchanged."""
WITHIN = 0.25
"""After that, fits whose score is lower than the best by more than this are not handed over."""
PATH_COST = 10.0
"""Cost of the mean change of path lengths along the body, in the merit of a fit. Chosen on the fits of 72
maps between scans with a third to two thirds of the surface missing."""
ALIKE = 0.075
"""Mean distance between two maps, in sqrt(area), below which they differ in a limb, not as a whole."""
SAME_REGION = 0.1
"""Medial centres closer than this, in sqrt(area), are of one region."""
STAYING = 0.8
"""Share of the points to be moved from which a map stays where it is. Of the outer half of a quadruped the
left-right symmetry leaves .44 (head and tail), with two legs not found .68, a turn of front to back all."""
STAYING_COST = 0.5
"""Cost of that share in the score: part of a body turned from front to back strains less than it should."""


def staying(cloud: Cloud, points: Int, matches: Int) -> float:
    """Share of points that a map of a cloud to itself leaves in the medial region that they are in.

    Parameters
    ----------
    cloud
        Lengths are in sqrt(area).
    points, matches : (s,) int64
    """
    gap = np.linalg.norm(cloud.centers[matches] - cloud.centers[points], axis=1)
    return float((gap < SAME_REGION).mean()) if len(gap) else 0.0


@dataclass(frozen=True)
class Placed:
    """Where a fit of either way puts the samples of the pair's source.

    Attributes
    ----------
    places : (s, 3) float64
        On the pair's target.
    score : float
        Of the fit. For a cloud and its mirror image, less the cost of what stays where it is, and of paths
        as in the merit: both have the same gaps.
    merit : float
        The score, less the cost of paths along the body that the map makes longer or shorter. A shank on
        the other leg's knee fits as well as on its own, but is elsewhere along the body.
    """

    places: NDArray[np.float64]
    score: float
    merit: float

    def gap(self, other: "Placed") -> float:
        """Mean distance between two placements."""
        return float(np.linalg.norm(self.places - other.places, axis=1).mean())

    def like(self, other: "Placed") -> bool:
        """Whether two placements differ by no more than a limb."""
        return self.gap(other) < ALIKE

    def lead(self, other: "Placed") -> float:
        """How much better this one is: by merit if they are alike, by score if not."""
        return self.merit - other.merit if self.like(other) else self.score - other.score


@dataclass(frozen=True)
class End:
    """One of the two clouds of a pair, prepared.

    Attributes
    ----------
    side : Side
    cloud : Cloud
        In the units of the pair.
    paths : MedialPaths, optional
        Where sets by path length are wanted.
    cover : (c,) int64
        At most `MOST_POINTS` points, in farthest-point order: what the search sees of the cloud.
    """

    side: Side
    cloud: Cloud
    paths: MedialPaths | None
    cover: Int


class Way:
    """One end of a pair deformed onto the other, with few nodes, samples alone.

    Parameters
    ----------
    source, target
        Here: of this way, not of the pair.
    coordinates : (n, d) float32
        `medial.matching.neighbourhoods` of the source.
    times : (T,) float64
        Shared by the pair.
    config
    backward
        Whether the source of this way is the target of the pair.
    to_move : (n,) bool, optional
        One cloud is the mirror image of the other, point by point, and most of these points have to leave
        their medial region.
    """

    def __init__(
        self,
        source: End,
        target: End,
        coordinates: Float32,
        times: NDArray[np.float64],
        config: MatchConfig,
        backward: bool,
        to_move: NDArray[np.bool_] | None = None,
    ) -> None:
        self.source, self.target, self.times, self.config = source, target, times, config
        self.coordinates, self.backward, self.to_move = coordinates, backward, to_move
        nodes = max(2, min(config.nodes, len(source.cloud) // 4))
        rows = source.side.samples
        self.graph, self.attachment = NodeGraph.over(coordinates, source.cloud.points, rows, nodes)
        self._quick = Registration.between(
            self.graph, self.attachment, source.cloud, target.cloud, rows, target.cover, target.side.samples
        )

    def sets(self, starts: Int) -> list[Int]:
        """Landmark sets of the diffusion from first landmarks: source and target points of the pair."""
        here, there = self.source.side, self.target.side
        return [self.turn(pairs) for pairs in diffusion_sets(here, there, self.times, self.config, starts)]

    def sets_by_length(self) -> list[LandmarkSet]:
        """Landmark sets that agree in path length, where those are wanted: source and target of the pair."""
        if self.source.paths is None or self.target.paths is None:
            return []
        return [self._turn_nodes(each) for each in path_sets(self.source.paths, self.target.paths)]

    def turn(self, landmarks: Int) -> Int:
        """Landmarks (L, 2) of the pair as those of this way, and the other way round."""
        return landmarks[:, ::-1] if self.backward else landmarks

    def _turn_nodes(self, each: LandmarkSet) -> LandmarkSet:
        return LandmarkSet(each.target, each.source, each.cost) if self.backward else each

    def grown(self, sets: list[Int], by_length: list[LandmarkSet]) -> list[Candidate]:
        """The candidates that landmark sets of the pair make."""
        here, there = self.source, self.target

        def spread(pairs: Int) -> Candidate:
            return grown(here.side, there.side, self.turn(pairs), self.config)

        def by_paths(landmarks: LandmarkSet) -> Candidate:
            assert here.paths is not None
            assert there.paths is not None
            return grown_by_paths(here.side, here.paths, there.paths, self._turn_nodes(landmarks))

        return run_tasks(spread, [(s,) for s in sets]) + run_tasks(by_paths, [(s,) for s in by_length])

    def follow(self, candidates: list[Candidate]) -> list[Fit]:
        """Deform along each candidate; in the order given."""
        return run_tasks(lambda c: self._quick.judge(self._along(c.at_samples)), [(c,) for c in candidates])

    def settle(self, followed: list[Fit]) -> list[Fit]:
        """Settle the distinct ones for some rounds, the promising of these to the end, and the best anew."""
        few = [(fit.pose, QUICK, 0, EARLY) for fit in distinct(followed, len(followed), LIKE)]
        begun = run_tasks(self._quick.settle, few)
        rest = [(fit.pose, QUICK, EARLY) for fit in distinct(begun, PROMISING)]
        settled = run_tasks(self._quick.settle, rest)
        anew = [(fit.pose, stiff) for fit in distinct(settled, ANEW) for stiff in STIFF]
        return settled + run_tasks(self._quick.settle, anew)

    def from_rigid(self) -> list[Fit]:
        """Settle from rigid motions that take principal axes to principal axes."""
        poses = rigid_poses(self.graph, self.source.cloud.points, self.target.cloud.points)
        begun = run_tasks(self._quick.settle, [(pose, RIGID, 0, RIGID_EARLY) for pose in poses])
        rest = [(fit.pose, RIGID, RIGID_EARLY) for fit in distinct(begun, RIGID_KEPT)]
        return run_tasks(self._quick.settle, rest)

    def exchange(self, fits: list[Fit]) -> list[Fit]:
        """Distinct fits, best first, after parts were exchanged between them if that is wanted."""
        rule = Exchange()
        return recombine(self._quick, fits, rule) if self.config.recombine else distinct(fits, rule.donors)

    def turned(self, other: "Way", fits: list[Fit]) -> list[Fit]:
        """Fits of the other way turned round: this source goes where the other's deformation meets it."""
        return run_tasks(lambda fit: self._turned(other, fit), [(fit,) for fit in fits])

    def _turned(self, other: "Way", fit: Fit) -> Fit:
        return self._quick.settle(self._along(other.reaching(fit)), QUICK)

    def _along(self, goal: Int) -> Pose:
        cloud = self.target.cloud
        return self._quick.follow(cloud.points[goal], cloud.normals[goal], QUICK)

    def reaching(self, fit: Fit) -> Int:
        """The source sample that comes nearest to each sample of the target, as source point ids."""
        samples, cloud = self.target.side.samples, self.target.cloud
        deformed = features(*self._quick.moved(fit.pose))
        near = nearest_places(deformed, features(cloud.points[samples], cloud.normals[samples]))
        return self.source.side.samples[near]

    def changed(self, fit: Fit, reaching: Int) -> float:
        """How much a fit changes paths along the body (`path_distortion`), there and back; 0 without paths.

        Both count alike, so that fits of the two ways compare: where two limbs come to lie on one, the paths
        of the one say little and those of the two say much. `reaching` is that of the fit.
        """
        here, there = self.source, self.target
        if here.paths is None or there.paths is None:
            return 0.0
        out = path_distortion(here.paths, there.paths, here.side.samples, fit.partner)
        home = path_distortion(there.paths, here.paths, there.side.samples, reaching)
        return (out + home) / 2

    def staying(self, fit: Fit) -> float:
        """Share of the points to be moved that a fit to the mirror image leaves in their medial region."""
        if self.to_move is None:
            return 0.0
        samples = self.source.side.samples
        some = self.to_move[samples]
        return staying(self.source.cloud, samples[some], fit.partner[some])

    def placed(self, fit: Fit) -> Placed:
        """Where a fit puts the samples of the pair's source; of the way back, by the nearest sample."""
        reaching = self.reaching(fit)
        places = self.source.cloud.points[reaching] if self.backward else fit.moved
        score, cost = fit.score - STAYING_COST * self.staying(fit), PATH_COST * self.changed(fit, reaching)
        return Placed(places, score if self.to_move is None else score - cost, score - cost)

    def fine(self, nodes: int) -> FineDeformation:
        """Fine deformations the same way."""
        here, there = self.source, self.target
        covers = here.cover, there.cover
        return FineDeformation(here.cloud, there.cloud, covers, self.coordinates, here.side.samples, nodes)


class Sets:
    """Landmark sets of a pair, in two helpings: what every pair needs, and more for the hard ones.

    The first helping takes half of the first landmarks from either cloud, and tries every set both ways. With
    one way there is one helping, of all landmarks of the source.

    Parameters
    ----------
    ways
        One or two.
    rngs
        For the source and the target.
    """

    def __init__(self, ways: list[Way], rngs: list[np.random.Generator]) -> None:
        self.ways = ways
        time, config = middle_time(ways[0].times), ways[0].config
        self._starts = [
            first_landmarks(way.source.side, time, config, rng) for way, rng in zip(ways, rngs, strict=False)
        ]
        self._half = -(-len(self._starts[0]) // len(ways))

    def first(self) -> list[list[Candidate]]:
        """Candidates of each way."""
        sets = [pairs for way, starts in self._each() for pairs in way.sets(starts[: self._half])]
        by_length = self.ways[0].sets_by_length()
        return [way.grown(sets, by_length) for way in self.ways]

    def more(self) -> list[list[Candidate]]:
        """Further candidates of each way: from the other half of its first landmarks, and the way back."""
        return [
            way.grown(way.sets(starts[self._half :]), way.sets_by_length() if way.backward else [])
            for way, starts in self._each()
        ]

    def _each(self) -> list[tuple[Way, Int]]:
        return list(zip(self.ways, self._starts, strict=True))


def search(ways: list[Way], fits: list[list[Fit]]) -> list[list[Fit]]:
    """Hand settled fits from way to way and exchange parts.

    Parameters
    ----------
    ways
        One or two.
    fits
        Settled fits of each way.

    Returns
    -------
    list of list of Fit
        Of each way, best first. Fits that differ in one limb alone, which go as one until then, are apart.
    """
    fits = _handed_over(ways, fits, [distinct(each, HANDED_OVER) for each in fits])
    fits = [way.exchange(each) + each for way, each in zip(ways, fits, strict=True)]
    best = max(fit.score for each in fits for fit in each)
    good = [[fit for fit in distinct(each, HANDED_OVER, LIKE) if fit.score > best - WITHIN] for each in fits]
    return [distinct(each, len(each), LIKE) for each in _handed_over(ways, fits, good)]


def _handed_over(ways: list[Way], fits: list[list[Fit]], handed: list[list[Fit]]) -> list[list[Fit]]:
    """The fits of each way and some of the other one, turned round."""
    if len(ways) == 1:
        return fits
    (there, back), (out, home) = ways, handed
    return [fits[0] + there.turned(back, home), fits[1] + back.turned(there, out)]
