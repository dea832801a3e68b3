"""Mesh noise that leaves the truth exact: vertices slide along the surface and are numbered anew."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from datasets_gen.collection import Collection
from datasets_gen.meshes.geometry import scaled_face_normals

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

STRONGEST = 0.4
"""Largest shift, as a share of the way to a neighbour."""
SMALLEST_TURN = 0.2
"""Cosine of the angle by which a face may turn; faces that turn more pull their vertices back."""


def with_mesh_noise(collection: Collection, amount: float, seed: int) -> Collection:
    """The same surfaces under another mesh, alike in all poses.

    Each vertex moves to a point of one of its faces, the same point of the skin in every pose, so that vertex
    i remains one place. Vertices and faces are then numbered at random: nothing of how the mesh was made is
    left in their order, such as one half after the other. The mirror map is numbered anew, too; with the
    shift it is right to within an edge.

    Parameters
    ----------
    collection
    amount
        Largest shift in [0, `STRONGEST`], as a share of the way to a neighbour; evenly distributed.
    seed

    Returns
    -------
    Collection
        Of the same subject, poses and number of vertices.
    """
    rng = np.random.default_rng(seed)
    shapes = {shape.pose: shape for shape in (collection.reference, *collection.shapes)}
    faces = collection.reference.faces.astype(np.int64)
    stacked = np.stack([shape.vertices for shape in shapes.values()])
    moved = _slid(stacked, faces, amount, rng)
    order = rng.permutation(stacked.shape[1])  # order[i] is the old number of vertex i
    number = np.argsort(order)
    renumbered = number[faces][rng.permutation(len(faces))].astype(collection.reference.faces.dtype)
    found = {
        pose: replace(shape, vertices=vertices[order], faces=renumbered)
        for (pose, shape), vertices in zip(shapes.items(), moved, strict=True)
    }
    return replace(
        collection,
        shapes=tuple(found[pose] for pose in collection.poses),
        reference=found[collection.reference.pose],
        mirror=None if collection.mirror is None else number[collection.mirror[order]],
    )


def _slid(poses: Array, faces: Ints, amount: float, rng: np.random.Generator) -> Array:
    """Vertices (p, v, 3) moved into one of their faces (f, 3) each, turning no face over in any pose."""
    count = poses.shape[1]
    corner = rng.permutation(3 * len(faces))
    face_of = np.empty(count, dtype=np.int64)
    face_of[faces.ravel()[corner]] = corner // 3  # the last of each vertex's corners in random order
    others = faces[face_of]
    place = (others == np.arange(count)[:, None]).argmax(axis=1)
    first = others[np.arange(count), (place + 1) % 3]
    second = others[np.arange(count), (place + 2) % 3]
    share = rng.uniform(np.zeros(count), 1.0)
    shift = rng.uniform(np.zeros(count), amount)
    towards = share[:, None] * poses[:, first] + (1 - share)[:, None] * poses[:, second] - poses
    before = [scaled_face_normals(each, faces) for each in poses]
    while True:
        moved = poses + shift[:, None] * towards
        bad = np.zeros(len(faces), dtype=bool)
        for old, each in zip(before, moved, strict=True):
            new = scaled_face_normals(each, faces)
            length = np.linalg.norm(old, axis=1) * np.linalg.norm(new, axis=1)
            bad |= np.einsum("fd,fd->f", old, new) < SMALLEST_TURN * length
        if not bad.any():
            return np.asarray(moved)
        shift[faces[bad]] *= 0.5
        shift[shift < 1e-3 * amount] = 0.0
