"""Skin of rigs made elsewhere: linear blending with the rig's own weights, and poses put together."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from datasets_gen.checks import admitted, flat_faces
from datasets_gen.collection import Collection
from datasets_gen.meshes.mirroring import mirror_map
from datasets_gen.records import InputError
from datasets_gen.shape import Shape

Array = NDArray[np.float64]


def linear_blend_skinning(vertices: Array, weights: csr_array, turns: Array, shifts: Array) -> Array:
    """Vertices moved by the weighted means of the rigid motions of their bones [Magnenat-Thalmann 1988].

    What the packages with these rigs do; the weights were made for it.

    Parameters
    ----------
    vertices : (v, 3)
    weights : (v, b) sparse
        Rows sum to 1.
    turns : (b, 3, 3), shifts : (b, 3)
        Motion of each bone, x -> turn x + shift.

    Returns
    -------
    (v, 3)
    """
    motions = np.concatenate([turns, shifts[:, :, None]], axis=2).reshape(len(turns), 12)
    blended = (weights @ motions).reshape(-1, 3, 4)
    return np.einsum("vij,vj->vi", blended[:, :, :3], vertices) + blended[:, :, 3]


def standing(vertices: Array) -> Array:
    """The vertices (v, 3) moved so that they stand on y = 0 with their middle over the origin."""
    low, high = vertices.min(axis=0), vertices.max(axis=0)
    return vertices - [(low[0] + high[0]) / 2, low[1], (low[2] + high[2]) / 2]


def collected(subject: str, faces: NDArray[np.integer], posed: Mapping[str, Array]) -> Collection:
    """A collection in metres of poses that share their faces; the first is the reference.

    Parameters
    ----------
    subject
    faces : (f, 3)
    posed
        Vertices (v, 3) by pose.

    Raises
    ------
    InputError
        If a mesh cannot be scanned (`datasets_gen.checks.check_mesh`).
    """
    made = [
        Shape(standing(vertices), faces.astype(np.int32), f"{subject}/{pose}", subject, pose, "m")
        for pose, vertices in posed.items()
    ]
    reference = admitted(made[:1])[0]
    shapes = [replace(shape, faces=reference.faces) for shape in made]
    for shape in shapes:  # the faces are shared: all that may differ between poses is their area
        if flat_faces(shape).any():
            raise InputError(f"{shape.name!r} has faces without area; leave its pose out of `poses`")
    return Collection(subject, tuple(shapes), shapes[0], mirror_map(shapes[0]))
