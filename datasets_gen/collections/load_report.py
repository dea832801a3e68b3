"""The report that a collection keeps of its meshes: size, connectivity, closedness, winding, duplicates."""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.checks import (
    edge_face_counts,
    face_components,
    flat_faces,
    looks_inward,
    repeated_corners,
    winding_conflicts,
)
from datasets_gen.meshes.boundaries import boundary_loops
from datasets_gen.shape import Shape

UNITS = ((0.5, 3.0, "m"), (50.0, 300.0, "cm"), (500.0, 3000.0, "mm"))
"""Sizes of people and animals, shortest and longest diagonal, in each unit."""


def mesh_report(shape: Shape) -> list[str]:
    """What there is to say of a mesh as it is, a line each.

    Parameters
    ----------
    shape
        With vertex ids in range.

    Returns
    -------
    list of str
        Its size; then its pieces, holes and winding in a line; then what is wrong with it.
    """
    vertices, faces = shape.vertices, shape.faces
    pieces = len(np.unique(face_components(faces)))
    rims = boundary_loops(faces)
    whole = "one piece" if pieces == 1 else f"{pieces:,} pieces"
    holes = (
        f"{len(rims)} hole{'s' if len(rims) > 1 else ''}, the longest rim of {max(rims)} edges"
        if rims
        else ""
    )
    state = [f"open ({holes})" if rims else "closed", whole]
    conflicts = winding_conflicts(once(faces))
    if pieces == 1 and not rims and not conflicts and (edge_face_counts(faces) == 2).all():
        state.append(f"genus {_genus(faces)}")
    if not conflicts:
        state.append("faces look inward" if looks_inward(vertices, faces) else "wound consistently")
    found = {
        "faces repeat others": len(faces) - len(np.unique(np.sort(faces, axis=1), axis=0)),
        "faces name a vertex twice": int(repeated_corners(faces).sum()),
        "vertices belong to no face": len(vertices) - len(np.unique(faces)),
        "vertices lie where others do": len(vertices) - len(np.unique(vertices, axis=0)),
        "edges have more than two faces": int((edge_face_counts(once(faces)) > 2).sum()),
        "edges have faces wound against each other": conflicts,
    }
    told = [f"{len(vertices):,} vertices, {len(faces):,} faces, {size_of(shape)}", ", ".join(state)]
    return told + [f"{count:,} {what}" for what, count in found.items() if count]


def poses_report(files: list[Shape], sound: list[Shape]) -> tuple[str, ...]:
    """What poses that share their faces were found to be, and what was changed in all of them.

    Parameters
    ----------
    files
        As read; the first stands for all.
    sound
        As they are used, in the same order.
    """
    before, after = files[0], sound[0]
    told = mesh_report(before)
    if len(after.faces) != len(before.faces) or len(after.vertices) != len(before.vertices):
        told += [
            f"repaired: {len(after.vertices):,} vertices and {len(after.faces):,} faces are kept",
            f"as it is used: {', '.join(mesh_report(after)[1:])}",
        ]
    elif not np.array_equal(before.faces, after.faces):
        told.append(f"faces turned round: {', '.join(mesh_report(after)[1:])}")
    remarks = [f"{before.name}: {remark}" for remark in told]
    flat = [(shape.name, int(flat_faces(shape).sum())) for shape in sound]
    return (*remarks, *(f"{name}: {count} faces have no area" for name, count in flat if count))


def size_of(shape: Shape) -> str:
    """How large a shape is, and in which unit a person or an animal is as large."""
    size = shape.diagonal
    if shape.units != "unknown":
        return f"diagonal {size:.3g} {shape.units}"
    guess = next((f"; perhaps {unit}" for low, high, unit in UNITS if low <= size <= high), "")
    return f"diagonal {size:.3g} of unknown units{guess}"


def once(faces: NDArray[np.int32]) -> NDArray[np.int32]:
    """Faces (f, 3) without repetitions."""
    return faces[np.unique(np.sort(faces, axis=1), axis=0, return_index=True)[1]]


def _genus(faces: NDArray[np.integer]) -> int:
    """Handles of a closed surface in one piece, by Euler's formula."""
    return (2 - len(np.unique(faces)) + len(edge_face_counts(faces)) - len(faces)) // 2
