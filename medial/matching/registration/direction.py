"""A direction of deformation: the source onto the target, or the target onto the source.

Where both clouds are partial, one of the two directions is often the easier problem: a limb that is there
finds its way onto a body more easily than a body with a hole finds a limb. Each direction therefore starts
from its own candidates. Settled fits of one direction are inverted and registered again in the other
(`registration.search`), and what fits best in the end wins.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property

from datasets_gen.compiled import run_tasks
from medial.matching.common_units import Int
from medial.matching.landmarks.candidates import Candidate
from medial.matching.landmarks.rigid_starts import half_turns, principal_axes, rigid_poses
from medial.matching.prepared import PreparedCloud, PreparedPair
from medial.matching.registration.closest_points import nearest_places
from medial.matching.registration.deformation_graph import Float, NodeGraph, Pose, moved_centers
from medial.matching.registration.evidence import Weights, medial_gap
from medial.matching.registration.exchange import ExchangeLimits, distinct, exchange_parts
from medial.matching.registration.fit import Fit
from medial.matching.registration.refinement import FineDeformation
from medial.matching.registration.registration import Registration, Schedule, features
from medial.matching.registration.visibility import Visibility, from_one_side

QUICK = Schedule()
BALLS = 2000
"""Medial balls of the cloud that stays, by which quick fits are compared."""
LIKE = 0.02
"""Fits whose points are on average closer than this, in sqrt(area), before they settle count as one."""
EARLY = 5
"""Rounds of closest points before like fits are merged again and the worst are dropped."""
PROMISING = 12
"""Distinct fits of a direction that are settled to the end."""
ANEW = 6
"""Of those, distinct ones that are settled anew with each of `STIFF`."""
STIFF = tuple(Schedule(stiffness=(first, 0.01)) for first in (100.0, 300.0))
"""Nearly rigid at first: a misplaced limb is pulled back by the rest, and finds new closest points."""
RIGID = Schedule(rounds=25, stiffness=(1000.0, 0.01), reach=(0.25, 0.03))
"""From rigid motions: stiffer, and with a larger reach, as nothing is in place yet."""
RIGID_EARLY = 8
"""Rounds of `RIGID` after which only `RIGID_KEPT` fits go on."""
RIGID_KEPT = 6
"""Distinct fits from rigid motions that are settled to the end."""


@dataclass(frozen=True)
class DirectedFit(Fit):
    """A fit that knows its direction.

    Attributes
    ----------
    direction : Direction
        Which cloud is deformed, with how many nodes, and onto what.
    """

    direction: "Direction"

    @property
    def backward(self) -> bool:
        """Whether the target of the pair is deformed onto its source."""
        return self.direction.backward

    @cached_property
    def inverse(self) -> Int:
        """For each sample of the cloud that stays, the sample of the deformed one that is nearest to it.

        Returns
        -------
        (s,) int64
            Point ids of the deformed cloud. Nearest in position and normal.
        """
        here, there = self.direction.source, self.direction.target
        samples, cloud = there.descriptors.samples, there.cloud
        deformed = features(*self.direction.registration.moved(self.pose))
        near = nearest_places(deformed, features(cloud.points[samples], cloud.normals[samples]))
        return here.descriptors.samples[near]

    @cached_property
    def medial_gap(self) -> float:
        """How far the samples' medial balls, moved with the fit, are from `BALLS` of the other cloud."""
        direction, here, there = self.direction, self.direction.source.cloud, self.direction.target.cloud
        rows, balls = direction.source.descriptors.samples, direction.target.cover[:BALLS]
        hang = direction.attachment.rows(rows)
        centers = moved_centers(here.points[rows], here.centers[rows], hang, direction.graph, self.pose)
        return medial_gap(centers, here.radii[rows], there.centers[balls], there.radii[balls])


class Direction:
    """One cloud of a pair deformed onto the other, with few nodes; only its samples take part.

    Parameters
    ----------
    pair
        The prepared clouds. The one that is deformed needs its `coordinates`.
    backward
        Deform the target of the pair onto its source.
    shown
        What the pair's source and target show; None if both are taken to show everything.

    Attributes
    ----------
    source, target : PreparedCloud
        What is deformed, and what stays: of this direction, not of the pair.
    graph, attachment
        Nodes over the source, and how all its points hang on them.
    registration : Registration
        Of the samples of the source.
    """

    def __init__(
        self, pair: PreparedPair, backward: bool, shown: tuple[Visibility, Visibility] | None
    ) -> None:
        self.pair, self.backward = pair, backward
        self.shown = shown[::-1] if shown and backward else shown
        self.weights = Weights.of(pair.config.evidence)
        self.source, self.target = (pair.target, pair.source) if backward else (pair.source, pair.target)
        assert self.source.coordinates is not None
        self.coordinates = self.source.coordinates
        here, there, rows = self.source.cloud, self.target.cloud, self.source.descriptors.samples
        nodes = max(2, min(pair.config.nodes, len(here) // 4))
        self.graph, self.attachment = NodeGraph.over(self.coordinates, here.points, rows, nodes)
        self.registration = Registration.between(
            self.graph,
            self.attachment,
            here,
            there,
            rows,
            self.target.cover,
            self.target.descriptors.samples,
            self.shown,
            self.weights,
        )

    def follow(self, candidates: list[Candidate]) -> list[DirectedFit]:
        """Deform along each candidate, without closest points; in the order given."""
        judge = self.registration.judge
        return self._directed(
            run_tasks(lambda c: judge(self._along(c.at_samples)), [(c,) for c in candidates])
        )

    def settle(self, followed: list[DirectedFit]) -> list[DirectedFit]:
        """Settle the distinct fits for some rounds, the promising of these to the end, and the best anew."""
        settle = self.registration.settle
        few = [(fit.pose, QUICK, 0, EARLY) for fit in distinct(followed, len(followed), LIKE)]
        begun = run_tasks(settle, few)
        settled = run_tasks(settle, [(fit.pose, QUICK, EARLY) for fit in distinct(begun, PROMISING)])
        anew = [(fit.pose, stiff) for fit in distinct(settled, ANEW) for stiff in STIFF]
        return self._directed(settled + run_tasks(settle, anew))

    def from_rigid_motions(self) -> list[DirectedFit]:
        """Settle from rigid motions that take principal axes to principal axes."""
        settle = self.registration.settle
        poses = rigid_poses(self.graph, self.source.cloud.points, self.target.cloud.points)
        begun = run_tasks(settle, [(pose, RIGID, 0, RIGID_EARLY) for pose in poses])
        kept = distinct(begun, RIGID_KEPT)
        return self._directed(run_tasks(settle, [(fit.pose, RIGID, RIGID_EARLY) for fit in kept]))

    def half_turns(self, fit: DirectedFit) -> list[DirectedFit]:
        """Rivals of a fit: settled from the fit turned by half a turn about each of the target's axes.

        Bodies have such approximate symmetries: front for back, head for tail. They are made on purpose so
        that the fit is compared with them.
        """
        middle = fit.pose.positions.mean(axis=0)
        poses = [
            Pose(turn @ fit.pose.rotations, (fit.pose.positions - middle) @ turn.T + middle)
            for turn in half_turns(principal_axes(self.target.cloud.points))
        ]
        settle = self.registration.settle
        return self._directed(run_tasks(settle, [(pose, RIGID) for pose in poses]))

    def exchange(self, fits: list[DirectedFit]) -> list[DirectedFit]:
        """Distinct fits, best first, after parts were exchanged between them if that is wanted."""
        limits = ExchangeLimits()
        if not self.pair.config.recombine:
            return distinct(fits, limits.donors)
        return self._directed(exchange_parts(self.registration, fits, limits))

    def invert(self, fits: list[DirectedFit]) -> list[DirectedFit]:
        """Invert fits of the opposite direction and register them again in this one."""

        def inverted(fit: DirectedFit) -> Fit:
            return self.registration.settle(self._along(fit.inverse), QUICK)

        return self._directed(run_tasks(inverted, [(fit,) for fit in fits]))

    def fine(self, nodes: int) -> FineDeformation:
        """Prepare fine deformations in the same direction."""
        here, there = self.source, self.target
        covers = here.cover, there.cover
        return FineDeformation(
            here.cloud,
            there.cloud,
            covers,
            self.coordinates,
            here.descriptors.samples,
            nodes,
            self.shown,
            self.weights,
        )

    def _along(self, goal: Int) -> Pose:
        """The pose that takes the samples to points of the target, (s,)."""
        cloud = self.target.cloud
        return self.registration.follow(cloud.points[goal], cloud.normals[goal], QUICK)

    def _directed(self, fits: Iterable[Fit]) -> list[DirectedFit]:
        return [
            fit if isinstance(fit, DirectedFit) else DirectedFit(**vars(fit), direction=self) for fit in fits
        ]


def pair_directions(pair: PreparedPair) -> list[Direction]:
    """The source onto the target and, if both directions are wanted, the target onto the source."""
    both = pair.config.both_ways and pair.config.selection == "fit"
    shown = None
    if "visibility" in pair.config.evidence:
        first, second = run_tasks(Visibility.of, [_covered(pair.source), _covered(pair.target)])
        shown = first, second
    return run_tasks(Direction, [(pair, False, shown), (pair, True, shown)][: 2 if both else 1])


def one_side_each(pair: PreparedPair) -> bool:
    """Whether both clouds may have been seen from one side (`visibility.from_one_side`)."""
    if "visibility" not in pair.config.evidence:
        return False
    return all(run_tasks(from_one_side, [_covered(pair.source), _covered(pair.target)]))


def _covered(prepared: PreparedCloud) -> tuple[Float, Float]:
    """Points and normals of what a registration sees of a cloud, (c, 3) each."""
    cloud, cover = prepared.cloud, prepared.cover
    return cloud.points[cover], cloud.normals[cover]
