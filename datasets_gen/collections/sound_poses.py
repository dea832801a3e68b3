"""What is checked, changed and said when a data set of the field is loaded."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from datasets_gen.checks import (
    check_mesh,
    face_components,
    looks_inward,
    oriented,
    repeated_corners,
    sound_part,
    winding_conflicts,
)
from datasets_gen.collections.closing import fill_holes
from datasets_gen.collections.load_report import mesh_report, once, size_of
from datasets_gen.meshes.boundaries import boundary_loops
from datasets_gen.records import InputError
from datasets_gen.shape import Shape

SMALL_HOLE = 60
"""Longest rim, in edges, of a hole that is filled: the open eyes of TOSCA have fewer."""


def sound_poses(shapes: list[Shape], *, fill: bool) -> tuple[list[Shape], NDArray[np.int64], list[str]]:
    """Poses that share their faces, made fit for ground truth in all poses alike, with what was found.

    The largest piece is kept, without repeated and degenerate faces, and wound outward; small holes are
    filled if all can be.

    Parameters
    ----------
    shapes
        The first decides what is outward.
    fill
        Whether small holes are filled.

    Returns
    -------
    shapes : list of Shape
    kept : (w,)
        Vertices of the files that are kept.
    remarks : list of str

    Raises
    ------
    InputError
        As `datasets_gen.check_mesh`.
    """
    kept, faces = sound_part(shapes)
    first = shapes[0]
    remarks = _as_read(first, len(kept), len(faces))
    faces = oriented(faces, first.vertices[kept], first.name)
    rims = boundary_loops(faces)
    if rims:
        closed = _filled(first.vertices[kept], faces, rims) if fill else None
        done = "left open" if closed is None else f"filled with {len(closed) - len(faces)} faces"
        remarks.append(f"{len(rims)} holes, the longest rim of {max(rims)} edges: {done}")
        faces = faces if closed is None else closed
    sound = [replace(shape, vertices=shape.vertices[kept], faces=faces) for shape in shapes]
    remarks.append(f"as it is used: {', '.join(mesh_report(sound[0])[1:])}")
    told = [f"{first.name}: {remark}" for remark in remarks]
    for shape in sound:
        told += [
            f"{shape.name}: {remark}"
            for remark in check_mesh(shape, allow_flat=True)
            if not remark.startswith("open boundary")  # of all poses alike, as told above
        ]
    return sound, kept, told


def _filled(
    vertices: NDArray[np.float64], faces: NDArray[np.int32], rims: list[int]
) -> NDArray[np.int32] | None:
    """The faces and those that fill all holes, appended; None if one is large or cannot be filled."""
    if max(rims) > SMALL_HOLE or winding_conflicts(faces):
        return None
    try:
        return fill_holes(vertices, faces.astype(np.int64)).astype(np.int32)
    except InputError:
        return None


def _as_read(shape: Shape, vertices: int, faces: int) -> list[str]:
    """Remarks on a mesh as its file has it, of which so many vertices and faces are kept."""
    remarks = [f"{len(shape.vertices):,} vertices, {len(shape.faces):,} faces, {size_of(shape)}"]
    found = {
        "faces repeat others: dropped": len(shape.faces) - len(np.unique(np.sort(shape.faces), axis=0)),
        "faces name a vertex twice: dropped": int(repeated_corners(shape.faces).sum()),
        "vertices belong to no face: dropped": len(shape.vertices) - len(np.unique(shape.faces)),
        "vertices lie where others do": len(shape.vertices) - len(np.unique(shape.vertices, axis=0)),
        "edges have faces wound against each other": winding_conflicts(once(shape.faces)),
    }
    remarks += [f"{count:,} {what}" for what, count in found.items() if count]
    pieces = len(np.unique(face_components(shape.faces)))
    if pieces > 1:
        remarks.append(f"{pieces:,} pieces: the largest is kept, {vertices:,} vertices and {faces:,} faces")
    if looks_inward(shape.vertices, shape.faces):
        remarks.append("faces looked inward: flipped")
    return remarks
