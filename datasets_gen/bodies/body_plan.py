"""From a body plan to posed meshes: implicit surface, remeshed skin, weights, poses."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from datasets_gen.bodies.implicit_surface import Body
from datasets_gen.bodies.skeleton import Pose, Skeleton
from datasets_gen.bodies.skinning import DeltaMush, bone_of, diffused_weights, dual_quaternion_skinning
from datasets_gen.collection import Collection
from datasets_gen.meshes.remeshing import compact, remesh
from datasets_gen.shape import Shape

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


@dataclass(frozen=True)
class Detail:
    """A ball in which the mesh is finer.

    Attributes
    ----------
    bone : str
        Bone that it goes with.
    center : (3,)
    radius : float
    edge : float
        Wanted edge length inside.
    """

    bone: str
    center: Array
    radius: float
    edge: float


@dataclass(frozen=True)
class BodyPlan:
    """All that makes a body.

    Attributes
    ----------
    name : str
    skeleton : Skeleton
    surface : Body
    details : tuple of Detail
    edge : float
        Wanted edge length elsewhere, metres.
    spacing : float
        Grid of the first triangulation, metres; resolves the thinnest part.
    stiffness : float
        Longest distance over which neighbouring bones share the skin, metres.
    poses : mapping of str to Pose
        The first is the rest pose.
    symmetric : bool
        Whether the surface equals its mirror image across x = 0.
    held_out : mapping of str to Pose
        Further poses, which are given only where they are asked for by name, and are not for tuning.
    """

    name: str
    skeleton: Skeleton
    surface: Body
    details: tuple[Detail, ...]
    edge: float
    spacing: float
    stiffness: float
    poses: Mapping[str, Pose]
    symmetric: bool
    held_out: Mapping[str, Pose] = field(default_factory=dict)

    def sizing(self, points: Array) -> Array:
        """Wanted edge length at points (n, 3); grows by a quarter of the distance from a detail."""
        size = np.full(len(points), self.edge)
        for detail in self.details:
            away = np.maximum(np.linalg.norm(points - detail.center, axis=1) - detail.radius, 0)
            size = np.minimum(size, detail.edge + 0.25 * away)
        return size


def mesh_surface(plan: BodyPlan, rounds: int = 12) -> tuple[Array, Ints, Ints | None]:
    """Mesh the surface of a plan.

    A symmetric body is meshed on the side x >= 0 and completed by its mirror image, so that the mirror map
    is exact.

    Returns
    -------
    vertices (v, 3), faces (f, 3), mirror (v,) or None
    """
    from skimage.measure import marching_cubes  # imports scipy.optimize: a sixth of a second

    lower, upper = plan.surface.bounds()
    lower, upper = lower - 3 * plan.spacing, upper + 3 * plan.spacing
    if plan.symmetric:
        lower[0] = 0.0
    x, y, z = (np.arange(lower[k], upper[k] + plan.spacing, plan.spacing) for k in range(3))
    field = plan.surface.on_grid((x, y, z), far=4 * plan.spacing)
    field[np.abs(field) < 1e-6] = 1e-6  # a value of exactly zero makes triangles without area
    nodes, triangles, _, _ = marching_cubes(field, 0.0)
    vertices, faces = compact(nodes.astype(np.float64) * plan.spacing + lower, triangles.astype(np.int64))
    vertices, faces = remesh(vertices, faces, plan.sizing, Projector(plan.surface), rounds)
    return _completed(vertices, faces) if plan.symmetric else (vertices, faces, None)


@dataclass(frozen=True)
class Projector:
    """Newton steps along the gradient onto a surface.

    Attributes
    ----------
    surface : Body
    steps : int
    reach : float
        Longest step, metres.
    """

    surface: Body
    steps: int = 2
    reach: float = 0.005

    def __call__(self, points: Array, flat: NDArray[np.bool_]) -> Array:
        """Project points (n, 3); those flagged (n,) stay at x = 0."""
        points = points.copy()
        points[flat, 0] = 0
        for _ in range(self.steps):
            gradient = self.surface.gradient(points)
            gradient[flat, 0] = 0
            step = -self.surface(points)[:, None] * gradient
            step /= np.maximum(np.einsum("nd,nd->n", gradient, gradient), 0.25)[:, None]
            length = np.linalg.norm(step, axis=1, keepdims=True)
            points += step * np.minimum(1, self.reach / np.maximum(length, 1e-12))
        return points


def _completed(vertices: Array, faces: Ints) -> tuple[Array, Ints, Ints]:
    """Join a half body with its mirror image along x = 0."""
    seam = vertices[:, 0] == 0
    mirror = np.arange(len(vertices))
    mirror[~seam] = len(vertices) + np.arange((~seam).sum())
    both = np.concatenate([vertices, vertices[~seam] * [-1.0, 1, 1]])
    back = np.concatenate([mirror, np.flatnonzero(~seam)])
    return both, np.concatenate([faces, mirror[faces][:, ::-1]]), back


@dataclass(frozen=True)
class Skin:
    """A meshed body in its rest pose, and how its bones carry it.

    Attributes
    ----------
    vertices : (v, 3)
    faces : (f, 3)
    mirror : (v,) or None
    weights : (v, bones)
    skeleton : Skeleton
    """

    vertices: Array
    faces: Ints
    mirror: Ints | None
    weights: Array
    skeleton: Skeleton

    @classmethod
    def of_plan(cls, plan: BodyPlan) -> "Skin":
        """Mesh the surface of a plan, and let the heat of its bones diffuse along it."""
        vertices, faces, mirror = mesh_surface(plan)
        owner = bone_of(vertices, plan.surface, plan.skeleton)
        weights = diffused_weights(vertices, faces, owner, plan.skeleton, plan.stiffness)
        return cls(vertices, faces, mirror, weights, plan.skeleton)

    def posed(self, poses: Mapping[str, Pose], mush_steps: int = 12) -> dict[str, Array]:
        """Vertices (v, 3) in each pose; every pose stands on y = 0."""
        mush = DeltaMush.of_rest(self.vertices, self.faces, mush_steps)
        found = {}
        for name, pose in poses.items():
            posed = self.vertices
            if pose:
                moved = dual_quaternion_skinning(posed, self.weights, *self.skeleton.transforms(pose))
                posed = mush(moved)
            found[name] = posed - [0.0, posed[:, 1].min(), 0.0]
        return found


@threadpool_limits.wrap(limits=1, user_api="blas")  # the last bits of a product depend on the threads
def build_body(plan: BodyPlan) -> Collection:
    """Mesh a body plan and pose it; every pose stands on y = 0."""
    skin = Skin.of_plan(plan)
    return collection_of(plan.name, skin.faces, skin.posed(plan.poses), skin.mirror)


def collection_of(
    subject: str, faces: Ints, posed: Mapping[str, Array], mirror: Ints | None = None
) -> Collection:
    """A collection, in metres, of vertices (v, 3) by pose, the reference first."""
    shared = faces.astype(np.int32)
    shapes = [Shape(each, shared, f"{subject}/{pose}", subject, pose, "m") for pose, each in posed.items()]
    return Collection(subject, tuple(shapes), shapes[0], mirror)
