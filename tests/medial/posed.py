"""A small figure in several poses, and its registration onto them, with known truth."""

from dataclasses import replace
from functools import cache

import numpy as np
from scipy.spatial.transform import Rotation

from medial import Diffusion
from medial.matching.common_units import common_units
from medial.matching.landmarks.samples import spectral_samples
from medial.matching.neighbourhoods import neighbourhoods
from medial.matching.registration.deformation_graph import NodeGraph, Pose
from medial.matching.registration.registration import Registration
from tests.medial.clouds import body

RIGHT_ELBOW, LEFT_ELBOW = (0.5, 0.05, 0.39), (-0.45, 0.15, 0.15)
SOFT = 0.12
"""Half the length over which a joint bends."""


def right_arm(points):
    return points[:, 0] > 0.4


def left_arm(points):
    return points[:, 0] < -0.47


def legs(points):
    return points[:, 2] < -0.6


@cache
def figure(n=700, seed=0, modes=60):
    points, normals = body(n, seed)
    return Diffusion.from_points(points, normals, modes=modes)


def turns(points, right, left=0.0):
    """How each point turns, (n, 3, 3), and which joint it turns about, when the elbows bend (radians)."""
    out = np.tile(np.eye(3), (len(points), 1, 1))
    joint = np.zeros_like(points)
    for angle, elbow, side in ((right, RIGHT_ELBOW, 1), (left, LEFT_ELBOW, -1)):
        share = np.clip((side * (points[:, 0] - elbow[0]) + SOFT) / (2 * SOFT), 0, 1)
        joint[share > 0] = elbow
        out[share > 0] = Rotation.from_rotvec(np.outer(angle * share, [0, 1, 0]))[share > 0].as_matrix()
    return out, joint


def bent(points, normals, right, left=0.0):
    """Points and normals with bent elbows."""
    turn, joint = turns(points, right, left)
    return joint + np.einsum("nij,nj->ni", turn, points - joint), np.einsum("nij,nj->ni", turn, normals)


def bent_figure(right, left=0.0):
    """The figure with bent elbows and the spectrum that it has at rest."""
    points, normals = bent(figure().points, figure().normals, right, left)
    centers = bent(figure().centers, figure().normals, right, left)[0]
    return replace(figure(), points=points, normals=normals, centers=centers)


def rest_pose(graph):
    return Pose(np.tile(np.eye(3), (len(graph), 1, 1)), graph.rest.copy())


def rigid_pose(graph, turn, shift):
    return Pose(np.tile(turn, (len(graph), 1, 1)), graph.rest @ turn.T + shift)


class Setup:
    """The figure, registered onto another one. Lengths are in sqrt(area) but for `unit`, which is that."""

    def __init__(self, target, nodes=40, samples=250):
        source = figure()
        self.source, self.target = common_units(source, target)
        self.unit = np.linalg.norm(source.points[0]) / np.linalg.norm(self.source.points[0])
        coordinates = neighbourhoods(source)
        self.samples = spectral_samples(source, samples, np.random.default_rng(0))
        look_back = spectral_samples(target, samples, np.random.default_rng(1))
        self.graph, attachment = NodeGraph.over(coordinates, self.source.points, self.samples, nodes)
        self.points, self.normals = self.source.points[self.samples], self.source.normals[self.samples]
        self.registration = Registration(
            self.graph,
            self.points,
            self.normals,
            attachment.rows(self.samples),
            self.target.points,
            self.target.normals,
            np.arange(len(self.target)),
            look_back,
        )

    def bent(self, right, left=0.0):
        """Where the samples and their normals truly go."""
        here, normals = bent(self.points * self.unit, self.normals, right, left)
        return here / self.unit, normals


def error(setup, fit_or_pose, right, left=0.0):
    """Distance of every sample from where it truly goes when the elbows bend."""
    pose = getattr(fit_or_pose, "pose", fit_or_pose)
    return np.linalg.norm(setup.registration.moved(pose)[0] - setup.bent(right, left)[0], axis=1)


def mapped(setup, among, right, left=0.0):
    """Goals of a map that sends some samples to the other side of the body and the others where they go."""
    goal, normals = setup.bent(right, left)
    mirrored = goal[among] * [-1, 1, 1]
    near = np.linalg.norm(mirrored[:, None] - setup.target.points, axis=2).argmin(axis=1)
    goal[among], normals[among] = setup.target.points[near], setup.target.normals[near]
    return goal, normals
