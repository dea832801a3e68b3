r"""Deform one cloud onto another, starting from a rough map: the surface stage of matching, and its judge.

A map between medial regions is right up to the ambiguity around each limb, and a landmark set may be wrong
or mirrored. Bodies bend but hardly stretch, so the map is tried out: the source is deformed as rigidly as
possible, first pulling the medial centres to the centres of their matches (robustly: a consistent majority
wins), then letting the surfaces settle on each other by iterative closest points in position and normal, in
both directions. What remains tells how good the map was: the share of each surface that found the other, and
the strain of the deformation. A left-right flip shows too, as rigid parts cannot be reflected ([ZSCO*08] use
a deformation likewise).

References
----------
[ZSCO*08] Zhang, Sheffer, Cohen-Or, Zhou, van Kaick, Tagliasacchi: Deformation-driven
    shape correspondence. SGP 2008.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from medial.cloud import Cloud, Float, Int, farthest_order
from medial.deformation import DeformationGraph, Embedding, Pose, geman_mcclure, polar_rotations

STRAIN_SCALE = 0.5
"""Edges stretched by more than this lose their hold (two parts that only seemed to be one)."""


@dataclass(frozen=True, kw_only=True)
class RegistrationConfig:
    """Settings of `Registration`. Lengths are in square roots of the clouds' surface area."""

    nodes: int = 400
    """Nodes of the deformation graph."""
    points: int = 3000
    """Points of each cloud that take part (farthest-point subset)."""
    warm_up: int = 30
    """Rounds that follow the map."""
    rounds: int = 60
    """Rounds of closest points."""
    steps: int = 2
    """Updates of positions and rotations per round."""
    pull: float = 0.15
    """Error of the map that is still believed while warming up."""
    reach: tuple[float, float] = (0.12, 0.03)
    """Distance at which a closest point loses half its influence, first and last round."""
    stiffness: tuple[float, float] = (2.0, 0.05)
    """Weight of the edges, first and last round of closest points."""
    normal_length: float = 0.1
    """How far apart opposite unit normals count as, per unit of normal difference."""
    turning: float = 0.15
    """Weight of normals in the rotations."""

    @classmethod
    def coarse(cls) -> "RegistrationConfig":
        """A quick trial, to compare candidate maps."""
        return cls(nodes=150, points=1000, warm_up=15, rounds=20)


@dataclass(frozen=True)
class Fit:
    """How a map fared.

    Attributes
    ----------
    pose : Pose
    residual : float
        Median distance of deformed source points to the target, in square roots of area.
    source_coverage, target_coverage : float
        Share of each cloud that found the other, in [0, 1].
    strain : float
        Root mean square relative strain of the edges.
    """

    pose: Pose
    residual: float
    source_coverage: float
    target_coverage: float
    strain: float

    @property
    def score(self) -> float:
        """Coverage of both clouds less the strain; higher is better."""
        return self.source_coverage + self.target_coverage - 2 * self.strain


class Registration:
    """A pair of clouds, prepared once to try many maps.

    Parameters
    ----------
    source, target
        See `common_units`.
    config
    """

    def __init__(self, source: Cloud, target: Cloud, config: RegistrationConfig | None = None) -> None:
        self.config = config or RegistrationConfig()
        self.source, self.target = source, target
        self.graph = DeformationGraph(source.points, source.centers, self.config.nodes)
        self._taken = farthest_order(source.points, self.config.points)
        self._taken_there = farthest_order(target.points, self.config.points)
        self._points, self._normals = source.points[self._taken], source.normals[self._taken]
        self._centers = source.centers[self._taken]
        self._embedding = self.graph.embed(self._points, self._centers)
        self._pull = _hang(self.graph, self._embedding, self._centers)
        self._tree = cKDTree(self._features(target.points, target.normals))

    def _features(self, points: Float, normals: Float) -> Float:
        return np.hstack([points, self.config.normal_length * normals])

    def follow(self, source_to_target: NDArray[np.integer], confidence: Float | None = None) -> Pose:
        """Deform the source so that medial centres meet the centres of their matches.

        Parameters
        ----------
        source_to_target : (n_source,)
        confidence : (n_source,), optional
        """
        taken = self._taken
        matched = np.asarray(source_to_target)[taken]
        belief = np.ones(len(taken)) if confidence is None else np.asarray(confidence)[taken]
        goal = self.target.centers[matched]
        pose = self._rigid(self._centers, goal, belief)
        share = len(self.graph) / len(taken)
        hold = np.ones(len(self.graph.start))
        normals = self.target.normals[matched]
        for k in range(self.config.warm_up):
            scale = self.config.pull * max(3 * 0.9**k, 0.5)
            moved = self._pull.moved(pose)
            weights = belief * geman_mcclure(((moved - goal) ** 2).sum(axis=1), scale**2)
            if k > 5:
                hold = geman_mcclure(self.graph.strain2(pose), STRAIN_SCALE**2)
            stiffness = max(0.03, 10 * 0.85**k) * hold
            positions = self.graph.solve_positions(
                self._pull, pose.rotations, goal, weights * share, stiffness
            )
            rotations = self.graph.fit_rotations(
                self._embedding, positions, hold, self._normals, normals, 0.5 * share * weights
            )
            pose = Pose(rotations, positions)
        return pose

    def _rigid(self, points: Float, goal: Float, belief: Float) -> Pose:
        """The rigid motion most of the map agrees with."""
        weights = belief
        for _ in range(20):
            share = weights / weights.sum()
            here, there = share @ points, share @ goal
            turn = polar_rotations(
                np.einsum("n,na,nb->ab", share, goal - there, points - here)[None] + 1e-12 * np.eye(3)
            )[0]
            square = ((goal - there - (points - here) @ turn.T) ** 2).sum(axis=1)
            weights = belief * geman_mcclure(square, (2 * self.config.pull) ** 2)
        positions = (self.graph.rest - here) @ turn.T + there
        return Pose(np.repeat(turn[None], len(self.graph), axis=0), positions)

    def settle(self, pose: Pose, first: int = 0, last: int | None = None) -> Fit:
        """Let the surfaces settle on each other from a pose (closest points, both directions).

        Parameters
        ----------
        pose
        first, last
            Rounds to run, of `config.rounds`; all by default.
        """
        config = self.config
        share = len(self.graph) / len(self._points)
        for k in range(first, config.rounds if last is None else last):
            done = k / max(config.rounds - 1, 1)
            reach, stiffness = (a * (b / a) ** done for a, b in (config.reach, config.stiffness))
            goal, belief, seen, seen_normals = self._goals(pose, reach)
            for _ in range(config.steps):
                hold = geman_mcclure(self.graph.strain2(pose), STRAIN_SCALE**2)
                positions = self.graph.solve_positions(
                    self._embedding, pose.rotations, goal, belief * share, stiffness * hold
                )
                rotations = self.graph.fit_rotations(
                    self._embedding,
                    positions,
                    hold,
                    self._normals,
                    seen_normals,
                    config.turning * share * seen,
                )
                pose = Pose(rotations, positions)
        return self._judge(pose)

    def _goals(self, pose: Pose, reach: float) -> tuple[Float, Float, Float, Float]:
        """Where the points should go, from closest points in both directions.

        Returns
        -------
        goal : (n, 3)
        belief : (n,)
            Weight of the goals.
        seen : (n,)
            The part of it that comes from the points' own closest points.
        seen_normals : (n, 3)
            Normals of those.
        """
        there, there_normals = self.target.points[self._taken_there], self.target.normals[self._taken_there]
        moved = self._embedding.moved(pose)
        normals = self._embedding.turned_normals(self._normals, pose)
        features = self._features(moved, normals)
        _, near = self._tree.query(features)
        seen_normals = self.target.normals[near]
        goal, seen = _towards(moved, self.target.points[near], normals, seen_normals, reach)
        _, back = cKDTree(features).query(self._features(there, there_normals))
        goal_back, belief_back = _towards(moved[back], there, normals[back], there_normals, reach)
        belief = seen + np.bincount(back, belief_back, minlength=len(moved))
        pulled = seen[:, None] * goal
        for axis in range(3):
            pulled[:, axis] += np.bincount(back, belief_back * goal_back[:, axis], minlength=len(moved))
        return pulled / np.maximum(belief, 1e-12)[:, None], belief, seen, seen_normals

    def _judge(self, pose: Pose) -> Fit:
        reach = self.config.reach[1]
        moved = self._embedding.moved(pose)
        normals = self._embedding.turned_normals(self._normals, pose)
        _, near = self._tree.query(self._features(moved, normals))
        found = _found(moved, self.target.points[near], normals, self.target.normals[near], reach)
        taken = self._taken_there
        there, there_normals = self.target.points[taken], self.target.normals[taken]
        _, back = cKDTree(self._features(moved, normals)).query(self._features(there, there_normals))
        found_back = _found(there, moved[back], there_normals, normals[back], reach)
        residual = float(np.median(np.linalg.norm(moved - self.target.points[near], axis=1)))
        strain = float(np.sqrt(np.minimum(self.graph.strain2(pose), 1).mean()))
        return Fit(pose, residual, float(found.mean()), float(found_back.mean()), strain)

    def adopt(self, other: "Registration", pose: Pose) -> Pose:
        """A pose of another registration of the same pair (a coarser one), carried over to this graph."""
        embedding = other.graph.embed(self.graph.rest, self.graph.rest_centers)
        blended = np.einsum("nk,nkab->nab", embedding.weights, pose.rotations[embedding.nodes])
        return Pose(polar_rotations(blended), embedding.moved(pose))

    def try_map(self, source_to_target: NDArray[np.integer], confidence: Float | None = None) -> Fit:
        """`follow` a map, then `settle`."""
        return self.settle(self.follow(source_to_target, confidence))

    def correspondence(self, pose: Pose) -> tuple[Int, Float, Float]:
        """Nearest target point, in position and normal, of every deformed source point.

        Returns
        -------
        source_to_target : (n_source,) int64
        distance : (n_source,) float64
            In square roots of area.
        agreement : (n_source,) float64
            Cosine of the normals.
        """
        embedding = self.graph.embed(self.source.points, self.source.centers)
        moved = embedding.moved(pose)
        normals = embedding.turned_normals(self.source.normals, pose)
        _, near = self._tree.query(self._features(moved, normals))
        distance = np.linalg.norm(moved - self.target.points[near], axis=1)
        return near.astype(np.int64), distance, (normals * self.target.normals[near]).sum(axis=1)


def _hang(graph: DeformationGraph, embedding: Embedding, points: Float) -> Embedding:
    """Other points (the medial centres) on the nodes of an embedding."""
    offsets = points[:, None] - graph.rest[embedding.nodes]
    return Embedding(embedding.nodes, embedding.weights, offsets)


def _towards(
    points: Float, goals: Float, normals: Float, goal_normals: Float, reach: float
) -> tuple[Float, Float]:
    """Where closest points pull to, mostly along the goal's normal, and how strongly."""
    step = goals - points
    along = (step * goal_normals).sum(axis=1, keepdims=True) * goal_normals
    return points + 0.8 * along + 0.2 * step, _found(points, goals, normals, goal_normals, reach)


def _found(points: Float, goals: Float, normals: Float, goal_normals: Float, reach: float) -> Float:
    """Belief, in [0, 1], that points and goals are the same: near, with like normals."""
    near = geman_mcclure(((goals - points) ** 2).sum(axis=1), reach**2)
    return near * np.clip((normals * goal_normals).sum(axis=1), 0, 1)
