"""Skeletons as files: PLY with edges, OBJ with lines, JSON, and the project's own ``.npz``."""

import json
import os
from pathlib import Path

import numpy as np

from datasets_gen.records import InputError, atomic_path
from medial.skeletons.curve_skeleton import CurveSkeleton


def write_skeleton(path: str | os.PathLike[str], skeleton: CurveSkeleton) -> None:
    """Write a skeleton in the format of the suffix; the file appears when it is complete.

    Parameters
    ----------
    path
        ``.ply`` (vertices ``x y z radius kind``, and the element ``edge``), ``.obj`` (``v`` and ``l``, which
        MeshLab and Blender show), ``.json`` (nodes, edges, radii, kinds, components, node of every point) or
        ``.npz``.
    skeleton

    Raises
    ------
    InputError
        If the suffix is another one, or the file cannot be written.
    """
    suffix = Path(path).suffix.lower()
    if suffix == ".npz":
        skeleton.save(path)
        return
    if suffix not in _TEXTS:
        raise InputError(f"cannot write {str(path)!r}; a skeleton is written as {', '.join(WRITTEN)}")
    with atomic_path(path) as temporary:
        temporary.write_text(_TEXTS[suffix](skeleton), encoding="utf-8")


def _ply(skeleton: CurveSkeleton) -> str:
    header = [
        "ply",
        "format ascii 1.0",
        f"comment curve skeleton by {skeleton.method or 'an unknown method'}",
        "comment kind: 0 alone, 1 tip, 2 inner, 3 joint",
        f"element vertex {len(skeleton)}",
        *(f"property double {name}" for name in ("x", "y", "z", "radius")),
        "property uchar kind",
        f"element edge {len(skeleton.edges)}",
        "property int vertex1",
        "property int vertex2",
        "end_header",
    ]
    kinds = np.minimum(skeleton.degrees, 3)
    rows = zip(skeleton.nodes.tolist(), skeleton.radii.tolist(), kinds.tolist(), strict=True)
    vertices = [f"{x!r} {y!r} {z!r} {radius!r} {kind}" for (x, y, z), radius, kind in rows]
    edges = [f"{a} {b}" for a, b in skeleton.edges.tolist()]
    return "\n".join([*header, *vertices, *edges, ""])


def _obj(skeleton: CurveSkeleton) -> str:
    head = [f"# curve skeleton by {skeleton.method or 'an unknown method'}"]
    vertices = [f"v {x!r} {y!r} {z!r}" for x, y, z in skeleton.nodes.tolist()]
    lines = [f"l {a + 1} {b + 1}" for a, b in skeleton.edges.tolist()]
    return "\n".join([*head, *vertices, *lines, ""])


def _json(skeleton: CurveSkeleton) -> str:
    table = {
        "method": skeleton.method,
        "reason": skeleton.reason,
        "nodes": skeleton.nodes.tolist(),
        "edges": skeleton.edges.tolist(),
        "radii": skeleton.radii.tolist(),
        "kinds": skeleton.kinds.tolist(),
        "components": skeleton.components.tolist(),
        "node_of_point": skeleton.node_of_point.tolist(),
    }
    return json.dumps(table) + "\n"


_TEXTS = {".ply": _ply, ".obj": _obj, ".json": _json}
WRITTEN = (".ply", ".json", ".obj", ".npz")
"""Suffixes of skeletons."""
