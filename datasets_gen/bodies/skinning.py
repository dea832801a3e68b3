"""Skin that follows bones: diffused weights, dual quaternions and a smoothing that keeps details.

References
----------
[BP07] I. Baran, J. Popovic, "Automatic rigging and animation of 3D characters", SIGGRAPH 2007.
[KCZ*07] L. Kavan et al., "Skinning with dual quaternions", I3D 2007.
[MDR*14] J. Mancewicz et al., "Delta Mush: smoothing deformations while preserving detail", DigiPro 2014.
"""

from dataclasses import dataclass

import numpy as np
import robust_laplacian
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array
from scipy.sparse.linalg import splu
from scipy.spatial.transform import Rotation

from datasets_gen.bodies.implicit_surface import Body
from datasets_gen.bodies.skeleton import Skeleton, segment_distance
from datasets_gen.meshes.geometry import vertex_normals
from datasets_gen.meshes.remeshing import Edges

Array = NDArray[np.float64]
Ints = NDArray[np.int64]


def bone_of(points: Array, body: Body, skeleton: Skeleton) -> Ints:
    """The bone that carries each point (n, 3): the nearest of those of the part that it lies on."""
    part_of = np.abs(body.distances(points)).argmin(axis=0)
    owner = np.empty(len(points), dtype=np.int64)
    for index, part in enumerate(body.parts):
        mine = part_of == index
        ids = [skeleton.index(name) for name in part.bones]
        segments = [(skeleton.bones[i].head, skeleton.bones[i].tail) for i in ids]
        away = np.stack([segment_distance(points[mine], *segment) for segment in segments])
        owner[mine] = np.array(ids)[away.argmin(axis=0)]
    return owner


def diffused_weights(
    vertices: Array, faces: Ints, owner: Ints, skeleton: Skeleton, stiffness: float
) -> Array:
    """Weights in equilibrium between heat from each vertex's own bone and diffusion along the skin [BP07].

    Solves (L + M H) w = M H p with the cotangent Laplacian L, masses M, p the indicator of the owner and
    H = 1 / d^2 with d the distance from the bone, at most `stiffness`: without this bound the thick trunk
    would follow the limbs.

    Returns
    -------
    (v, bones)
        Nonnegative, rows sum to 1.
    """
    laplacian, mass = robust_laplacian.mesh_laplacian(vertices, faces)
    near = np.empty(len(vertices))
    for i, part in enumerate(skeleton.bones):
        mine = owner == i
        near[mine] = segment_distance(vertices[mine], part.head, part.tail)
    heat = mass.diagonal() / np.clip(near, 1e-3, stiffness) ** 2
    indicator = np.zeros((len(vertices), len(skeleton.bones)))
    indicator[np.arange(len(vertices)), owner] = 1
    solver = splu((laplacian + diags_array(heat)).tocsc())
    weights = np.maximum(solver.solve(heat[:, None] * indicator), 0)
    return weights / weights.sum(axis=1, keepdims=True)


def dual_quaternion_skinning(vertices: Array, weights: Array, turns: Array, shifts: Array) -> Array:
    """Blend rigid motions as unit dual quaternions [KCZ*07].

    Parameters
    ----------
    vertices : (v, 3)
    weights : (v, b)
    turns : (b, 3, 3), shifts : (b, 3)
        Motion of each bone, x -> turn x + shift.

    Returns
    -------
    (v, 3)
    """
    real = Rotation.from_matrix(turns).as_quat()  # (b, 4), scalar last
    pure = np.concatenate([shifts, np.zeros((len(shifts), 1))], axis=1)
    dual = 0.5 * _product(pure, real)
    pivot = real[weights.argmax(axis=1)]
    signed = weights * np.where(pivot @ real.T < 0, -1.0, 1.0)
    blend, move = signed @ real, signed @ dual
    norm = np.linalg.norm(blend, axis=1, keepdims=True)
    blend, move = blend / norm, move / norm
    conjugate = blend * np.array([-1.0, -1, -1, 1])
    return Rotation.from_quat(blend).apply(vertices) + 2 * _product(move, conjugate)[:, :3]


def _product(p: Array, q: Array) -> Array:
    """Hamilton product of quaternions with the scalar last, (n, 4)."""
    pv, ps, qv, qs = p[:, :3], p[:, 3:], q[:, :3], q[:, 3:]
    scalar = ps * qs - np.sum(pv * qv, axis=1, keepdims=True)
    return np.concatenate([ps * qv + qs * pv + np.cross(pv, qv), scalar], axis=1)


@dataclass(frozen=True)
class DeltaMush:
    """Details of the rest pose in frames of its smoothed skin, put back onto a smoothed posed skin [MDR*14].

    Attributes
    ----------
    faces : (f, 3)
    smoother : (v, v) sparse
        One step of averaging with the neighbours.
    steps : int
    details : (v, 3)
        In the local frames.
    """

    faces: Ints
    smoother: csr_array
    steps: int
    details: Array

    @classmethod
    def of_rest(cls, vertices: Array, faces: Ints, steps: int) -> "DeltaMush":
        """Learn the details of the rest pose."""
        count = len(vertices)
        ends = Edges(faces).ends
        rows, columns = np.concatenate([ends, ends[:, ::-1]]).T
        graph = csr_array((np.ones(len(rows)), (rows, columns)), shape=(count, count))
        mean = diags_array(1 / graph.sum(axis=1)) @ graph
        smoother = csr_array(0.5 * (diags_array(np.ones(count)) + mean))
        empty = cls(faces, smoother, steps, np.zeros((count, 3)))
        smooth = empty._smoothed(vertices)
        details = np.einsum("nij,nj->ni", empty._frames(smooth), vertices - smooth)
        return cls(faces, smoother, steps, details)

    def __call__(self, vertices: Array) -> Array:
        """Smooth a posed skin (v, 3) and put the details back."""
        smooth = self._smoothed(vertices)
        return smooth + np.einsum("nij,ni->nj", self._frames(smooth), self.details)

    def _smoothed(self, vertices: Array) -> Array:
        for _ in range(self.steps):
            vertices = self.smoother @ vertices
        return vertices

    def _frames(self, vertices: Array) -> Array:
        """Orthonormal rows (normal, tangent, bitangent) of each vertex, (v, 3, 3)."""
        normal = vertex_normals(vertices, self.faces, "area")
        neighbour = np.empty(len(vertices), dtype=np.int64)
        neighbour[self.faces[:, 0]] = self.faces[:, 1]
        neighbour[self.faces[:, 1]] = self.faces[:, 2]
        neighbour[self.faces[:, 2]] = self.faces[:, 0]
        tangent = vertices[neighbour] - vertices
        tangent -= np.einsum("nd,nd->n", tangent, normal)[:, None] * normal
        tangent /= np.linalg.norm(tangent, axis=1, keepdims=True)
        return np.stack([normal, tangent, np.cross(normal, tangent)], axis=1)
