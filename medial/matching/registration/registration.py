"""Registration of one cloud onto another: follow a map, settle by rounds of closest points, judge the fit.

A map between medial regions is ambiguous around each limb, and a landmark set may be wrong or mirrored. A map
is right if the source settles on the target with little strain and each surface finds the other. A mirrored
map cannot do that, as rigid pieces do not reflect; [ZSCO*08] judge correspondences by deformation likewise.
A limb on the surface of another limb is as near to it as the right one is, but hangs on by torn edges.

References
----------
[ZSCO*08] Zhang, Sheffer, Cohen-Or, Zhou, van Kaick, Tagliasacchi: Deformation-driven shape correspondence.
    SGP 2008.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from medial.matching.common_units import CloudInUnits
from medial.matching.registration.closest_points import PlaceTree, meeting, nearest_places
from medial.matching.registration.deformation_graph import (
    Attachment,
    Float,
    Int,
    NodeGraph,
    Pose,
    moved,
    shares,
)
from medial.matching.registration.evidence import WEIGHTS, Weights
from medial.matching.registration.fit import Fit
from medial.matching.registration.normal_equations import NormalEquations
from medial.matching.registration.rigid_motions import local_motions
from medial.matching.registration.visibility import Visibility

NORMAL_LENGTH = 0.06
"""Length, in sqrt(area), that a unit of difference between normals counts as among closest points."""
EVEN = 0.1
"""Weight of the distance to a goal in all directions, relative to that along the goal's normal."""
BACKWARD = 0.5
"""Weight of target points that look for the source, relative to source points that look for the target."""
SEEN_WITHIN = 0.03
"""Distance, in sqrt(area), at which a point counts half as found."""
SMALLEST_SCALE = 0.01
"""Residuals below this, in sqrt(area), are no outliers when a node's motion is estimated."""
FOLLOW_STIFFNESS = 0.2
"""Stiffness while a map is followed, relative to that of the first round of closest points."""
BELIEVED = 0.1
"""Distance to where the map sends a point, in sqrt(area), at which it loses much of its pull."""

Expected = tuple[Float | float, Float | float]
EVERYTHING: Expected = (1.0, 1.0)


@dataclass(frozen=True, kw_only=True)
class Schedule:
    """How a registration proceeds. Weights are relative to a mean data weight of 1."""

    follow: int = 5
    """Rounds that follow the map."""
    rounds: int = 15
    """Rounds of closest points."""
    stiffness: tuple[float, float] = (3.0, 0.01)
    """Weight of the agreement of neighbouring nodes, first and last round."""
    reach: tuple[float, float] = (0.12, 0.03)
    """Distance to a closest point at which it loses much of its pull, first and last round."""
    unseen: float = 1.0
    """Weight of points that the other scan could not have seen, relative to those that it could."""


class Registration:
    """A pair of clouds, prepared to try many maps. All lengths are in units of sqrt(area).

    Parameters
    ----------
    graph
        Nodes over the source.
    points, normals : (n, 3)
        Source points that take part.
    attachment
        Of those points.
    target_points, target_normals : (m, 3)
    among : (a,) int64
        Target points that are looked for.
    look_back : (b,) int64
        Target points that look for the source.
    shown : (Visibility, Visibility), optional
        Of the source and of the target; without them both show everything.
    weights
        Of the evidence that fits are scored by.
    """

    def __init__(
        self,
        graph: NodeGraph,
        points: Float,
        normals: Float,
        attachment: Attachment,
        target_points: Float,
        target_normals: Float,
        among: Int,
        look_back: Int,
        shown: tuple[Visibility, Visibility] | None = None,
        weights: Weights = WEIGHTS,
    ) -> None:
        self.graph, self.attachment, self._shown, self._weights = graph, attachment, shown, weights
        self.points, self.normals = points, normals
        self.target_points, self.target_normals = target_points, target_normals
        self._back_points, self._back_normals = target_points[look_back], target_normals[look_back]
        self._among = among
        self._tree = PlaceTree(features(target_points[among], target_normals[among]))
        self._back_features = features(self._back_points, self._back_normals)

    @classmethod
    def between(
        cls,
        graph: NodeGraph,
        attachment: Attachment,
        source: CloudInUnits,
        target: CloudInUnits,
        rows: Int,
        among: Int,
        look_back: Int,
        shown: tuple[Visibility, Visibility] | None = None,
        weights: Weights = WEIGHTS,
    ) -> "Registration":
        """Some points of a cloud, all of which hang on the nodes, against another cloud.

        Parameters
        ----------
        graph
        attachment
            Of all points of the source.
        source, target
        rows : (n,) int64
            Source points that take part.
        among : (a,) int64
            Target points that are looked for.
        look_back : (b,) int64
            Target points that look for the source.
        shown, weights
            As for `Registration`.
        """
        here = graph, source.points[rows], source.normals[rows], attachment.rows(rows)
        return cls(*here, target.points, target.normals, among, look_back, shown, weights)

    def follow(self, goal: Float, goal_normals: Float, schedule: Schedule) -> Pose:
        """Deform the source along a map; points that their neighbours contradict count less.

        Parameters
        ----------
        goal, goal_normals : (n, 3)
            Where the map sends the points and their normals.
        schedule
            For its number of rounds and its first stiffness.

        Returns
        -------
        Pose
        """
        rotations, positions = local_motions(
            self.points,
            self.normals,
            goal,
            goal_normals,
            *self._wider,
            self.graph.rest,
            self.graph.reach,
            SMALLEST_SCALE,
        )
        pose, even, rows = Pose(rotations, positions), 1 / len(self.points), np.arange(len(self.points))
        for _ in range(schedule.follow):
            offset = self.moved(pose)[0] - goal
            weight = even * _robust(np.einsum("nd,nd->n", offset, offset), BELIEVED)
            equations = NormalEquations(self.graph, pose, self.points, self.attachment)
            equations.pull(rows, offset, goal_normals, weight, 0 * weight)
            pose = equations.step(FOLLOW_STIFFNESS * schedule.stiffness[0])
        return pose

    def settle(self, pose: Pose, schedule: Schedule, first: int = 0, last: int | None = None) -> Fit:
        """Let the surfaces settle on each other: closest points in position and normal, both ways.

        Parameters
        ----------
        pose
        schedule
        first, last
            Rounds of the schedule to run; all by default.

        Returns
        -------
        Fit
        """
        everything = np.arange(len(self.points))
        for k in range(first, schedule.rounds if last is None else last):
            done = k / max(schedule.rounds - 1, 1)
            stiffness, reach = (a * (b / a) ** done for a, b in (schedule.stiffness, schedule.reach))
            here, normals, near, back = self._meet(pose)
            equations = NormalEquations(self.graph, pose, self.points, self.attachment)
            shown = self._expected(pose, here, normals, back) if schedule.unseen < 1 else EVERYTHING
            for rows, goals, goal_normals, worth, expected in (
                (everything, self.target_points[near], self.target_normals[near], 1.0, shown[0]),
                (back, self._back_points, self._back_normals, BACKWARD, shown[1]),
            ):
                square, cosine = meeting(here[rows], normals[rows], goals, goal_normals)
                weight = worth / len(rows) * cosine**2 * _robust(square, reach)
                weight *= schedule.unseen + (1 - schedule.unseen) * expected
                equations.pull(rows, here[rows] - goals, goal_normals, EVEN * weight, weight)
            pose = equations.step(stiffness)
        return self.judge(pose)

    def judge(self, pose: Pose) -> Fit:
        """The fit of a pose: how well both surfaces find each other in it."""
        here, normals, near, back = self._meet(pose)
        met = found(here, normals, self.target_points[near], self.target_normals[near])
        met_back = found(here[back], normals[back], self._back_points, self._back_normals)
        return Fit(
            pose,
            here,
            near,
            met,
            met_back,
            self._missed(pose, here, normals, back, met, met_back),
            self.graph.strain(pose),
            float(self.graph.held(pose).mean()),
            self._weights,
        )

    def _missed(
        self, pose: Pose, here: Float, normals: Float, back: Int, met: Float, met_back: Float
    ) -> float:
        """`Fit.missed`: of points in a pose, and of target points that find the nearest ones, `back`."""
        shown, shown_back = self._expected(pose, here, normals, back)
        expected, expected_back = np.maximum(shown, met), np.maximum(shown_back, met_back)
        return float((expected * (1 - met)).mean() + (expected_back * (1 - met_back)).mean())

    def _expected(self, pose: Pose, here: Float, normals: Float, back: Int) -> Expected:
        """How surely the target would show the points of a pose, and the source target points that look back.

        Those are taken to the undeformed source, rigidly with the node that moves the point they found most.
        """
        if self._shown is None:
            return EVERYTHING
        source, target = self._shown
        turns = pose.rotations[self._main_node[back]]
        offset = np.einsum("nji,nj->ni", turns, self._back_points - here[back])
        rest_normals = np.einsum("nji,nj->ni", turns, self._back_normals)
        return target.expected(here, normals), source.expected(self.points[back] + offset, rest_normals)

    @cached_property
    def _main_node(self) -> Int:
        """Node that moves each point most, (n,)."""
        most = self.attachment.weights.argmax(axis=1)
        return np.asarray(self.attachment.nodes[np.arange(len(most)), most])

    def _meet(self, pose: Pose) -> tuple[Float, Float, Int, Int]:
        """Points and normals in a pose, their nearest target points, and whom the target points find."""
        here, normals = self.moved(pose)
        joined = features(here, normals)
        near = self._among[self._tree.nearest(joined)]
        return here, normals, near, nearest_places(joined, self._back_features)

    def moved(self, pose: Pose) -> tuple[Float, Float]:
        """Points and normals that take part, in a pose."""
        return moved(self.points, self.normals, self.attachment, self.graph, pose)

    @cached_property
    def _wider(self) -> tuple[Int, Int, Float]:
        """Points near each node or its neighbours, as (start, point, weight) in compressed rows."""
        share = shares(self.attachment, len(self.graph))
        overlap = (share.T @ share).toarray()
        wide = (share @ (overlap / overlap.sum(axis=1, keepdims=True))).T  # (N, n)
        node, point = np.nonzero(wide > 1e-2 * wide.max(axis=1, keepdims=True))
        start = np.searchsorted(node, np.arange(len(wide) + 1))
        return start.astype(np.int64), point.astype(np.int64), wide[node, point]


def found(points: Float, normals: Float, goals: Float, goal_normals: Float) -> Float:
    """How well points meet their goals, in [0, 1]: near, with like normals."""
    square, cosine = meeting(points, normals, goals, goal_normals)
    return np.asarray(cosine**2 / (1 + square / SEEN_WITHIN**2))


def features(points: Float, normals: Float) -> Float:
    """Points (n, 3) and unit normals as one vector (n, 6), whose distances are lengths."""
    return np.hstack([points, NORMAL_LENGTH * normals])


def _robust(square: Float, scale: float) -> Float:
    """Geman-McClure weight (1 + (r / s)^2)^-2 of squared residuals."""
    return 1 / (1 + square / scale**2) ** 2
