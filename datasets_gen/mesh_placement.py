"""The `MeshPlacement` type: where a mesh with faces of its own lies on the reference of its subject."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets_gen.meshes.nearest_faces import nearest_on_mesh
from datasets_gen.records import InputError
from datasets_gen.shape import Shape


@dataclass(frozen=True)
class MeshPlacement:
    """For each vertex of a mesh, the same surface point on the reference.

    What a part of a shape, or a shape that was meshed anew, has instead of shared vertices and faces.

    Attributes
    ----------
    face_ids : (v,) int32
        Face of the reference.
    barycentrics : (v, 3) float64
        Where in that face.
    """

    face_ids: NDArray[np.int32]
    barycentrics: NDArray[np.float64]

    @classmethod
    def of_vertices(cls, ids: NDArray[np.integer], reference: Shape) -> "MeshPlacement":
        """The placement that sends each vertex to a vertex of the reference.

        Parameters
        ----------
        ids : (v,)
        reference

        Raises
        ------
        InputError
            If an id is no vertex of the reference, or one that belongs to no face.
        """
        ids, count = np.asarray(ids, dtype=np.int64), len(reference.vertices)
        if len(ids) and (ids.min() < 0 or ids.max() >= count):
            wrong = int(ids.min() if ids.min() < 0 else ids.max())
            raise InputError(f"vertex {wrong} of {reference.name!r} is named, but it has {count} vertices")
        place = np.full(count, -1, dtype=np.int64)
        place[reference.faces.ravel()] = np.arange(reference.faces.size)
        corner = place[ids]
        if (corner < 0).any():
            wrong = int(ids[corner < 0][0])
            raise InputError(f"vertex {wrong} of {reference.name!r} is named, but belongs to no face")
        return cls((corner // 3).astype(np.int32), np.eye(3)[corner % 3])

    def carried(
        self,
        shape: Shape,
        reference: Shape,
        face_ids: NDArray[np.integer],
        barycentrics: NDArray[np.float64],
    ) -> tuple[NDArray[np.int32], NDArray[np.float64]]:
        """Surface points of the placed mesh as surface points of the reference.

        The places of a face's corners, weighted by the barycentrics, give a position next to the reference;
        its closest surface point is the place.

        Parameters
        ----------
        shape
            The mesh that is placed.
        reference
        face_ids : (n,)
        barycentrics : (n, 3)
            On the shape.

        Returns
        -------
        face_ids : (n,) int32
        barycentrics : (n, 3) float64
            On the reference.
        """
        corners = reference.at(self.face_ids, self.barycentrics)[shape.faces[face_ids]]  # (n, 3, 3)
        points = np.einsum("nc,ncd->nd", barycentrics, corners)
        return nearest_on_mesh(reference.vertices, reference.faces, points)
