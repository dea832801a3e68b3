"""What makes a mesh unusable, what is merely worth a line, and the repairs that can be made."""

import logging
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from datasets_gen.meshes.geometry import directed_edges, scaled_face_normals, solid_faces, undirected_edges
from datasets_gen.records import InputError
from datasets_gen.shape import Shape

_log = logging.getLogger(__name__)

FLAT_FACE = 1e-12  # area of a degenerate face, in squared bounding-box diagonals
LARGEST = 1e70  # coordinate; areas and their squares of larger meshes are infinite
OPEN = 0.1  # length of the mean face normal from which on a mesh is open; 0 if closed, 1 if flat


def edge_face_counts(faces: NDArray[np.integer]) -> NDArray[np.int64]:
    """How many faces meet at each undirected edge, (edges,)."""
    return undirected_edges(faces)[1]


def winding_conflicts(faces: NDArray[np.integer]) -> int:
    """How many directed edges are used more than once: 0 where neighbours agree on their orientation."""
    counts = np.unique(directed_edges(faces), axis=0, return_counts=True)[1]
    return int((counts > 1).sum())


def face_components(faces: NDArray[np.integer]) -> NDArray[np.int32]:
    """Label of the connected component of each face, (f,); faces that share a vertex are connected."""
    edges, size = directed_edges(faces), int(faces.max()) + 1
    graph = coo_array((np.ones(len(edges), dtype=np.int8), (edges[:, 0], edges[:, 1])), shape=(size, size))
    return connected_components(graph, directed=False)[1][faces[:, 0]]


def signed_volume(vertices: NDArray[np.float64], faces: NDArray[np.integer]) -> float:
    """Enclosed volume by the divergence theorem about the centroid; positive for outward-facing faces."""
    corners = (vertices - vertices[faces].mean(axis=(0, 1)))[faces]
    return float(np.einsum("fd,fd->", corners[:, 0], np.cross(corners[:, 1], corners[:, 2])) / 6)


def looks_inward(vertices: NDArray[np.float64], faces: NDArray[np.integer]) -> bool:
    """Whether the faces of a closed or nearly closed mesh look inward.

    An open surface such as a relief has no inside, and its normals do not cancel: false if their sum, over
    the area, exceeds `OPEN`.
    """
    if not signed_volume(vertices, faces) < 0:
        return False
    normals = scaled_face_normals(vertices, faces)
    return bool(np.linalg.norm(normals.sum(axis=0)) <= OPEN * np.linalg.norm(normals, axis=1).sum())


def check_mesh(shape: Shape, *, allow_flat: bool = False) -> tuple[str, ...]:
    """Check one mesh for what the scanner and the ground truth rely on.

    An open boundary, unused vertices and inward-facing faces only earn a remark: a scanner can look at such
    a mesh, and nothing downstream needs a volume. The rest is an error. Parts that are not connected have
    no geodesic distance between them; at an edge of three faces neither outside nor tangent plane is
    defined; a face without area has no barycentric coordinates.

    Parameters
    ----------
    shape
    allow_flat
        Remark on faces without area instead of refusing them.

    Returns
    -------
    tuple of str
        Remarks, each one line; empty for a closed, oriented mesh in one piece.

    Raises
    ------
    InputError
        For coordinates that are not finite, no faces, vertex ids out of range, faces without area, edges
        of more than two faces, several components, or faces wound against each other.
    """
    _check_arrays(shape)
    flat = int(flat_faces(shape).sum())
    if flat and not allow_flat:
        raise InputError(
            f"{shape.name!r} has {flat} degenerate faces (no area); repair=True goes on without them"
        )
    _check_topology(shape)
    return (*((f"{flat} faces have no area",) if flat else ()), *_remarks(shape))


def _check_arrays(shape: Shape) -> None:
    _check_ids(shape)
    _check_finite(shape, np.arange(len(shape.vertices)))


def _check_finite(shape: Shape, index: NDArray[np.integer]) -> None:
    bad = int((~np.isfinite(shape.vertices[index])).any(axis=1).sum())
    if bad:
        raise InputError(f"{shape.name!r} has {bad} vertices that are NaN or infinite; export it again")
    largest = float(np.abs(shape.vertices[index]).max(initial=0))
    if largest > LARGEST:
        raise InputError(f"{shape.name!r} has a coordinate of {largest:.3g}; choose larger units")


def _check_ids(shape: Shape) -> None:
    vertices, faces = shape.vertices, shape.faces
    if len(faces) == 0:
        raise InputError(f"{shape.name!r} has no faces; a point cloud cannot be scanned, give a mesh")
    if faces.min() < 0 or faces.max() >= len(vertices):
        found = int(faces.min() if faces.min() < 0 else faces.max())
        raise InputError(f"{shape.name!r} has a face with vertex {found}, but {len(vertices)} vertices")


def flat_faces(shape: Shape) -> NDArray[np.bool_]:
    """Which faces have (nearly) no area, (f,)."""
    return shape.face_areas <= FLAT_FACE * shape.diagonal**2


def repeated_corners(faces: NDArray[np.integer]) -> NDArray[np.bool_]:
    """Which faces name a vertex twice, (f,)."""
    return (faces == np.roll(faces, 1, axis=1)).any(axis=1)


def _check_topology(shape: Shape) -> None:
    edges, counts = undirected_edges(shape.faces)
    crowded = edges[counts > 2]
    if len(crowded):
        raise InputError(
            f"{shape.name!r} has {len(crowded)} non-manifold edges (more than two faces), one between "
            f"vertices {crowded[0, 0]} and {crowded[0, 1]}; clean it"
        )
    parts = len(np.unique(face_components(shape.faces)))
    if parts > 1:
        raise InputError(
            f"{shape.name!r} has {parts} components, which have no geodesic distance between them; "
            "repair=True keeps the largest"
        )
    conflicts = winding_conflicts(shape.faces)
    if conflicts:
        raise InputError(
            f"{shape.name!r} is not orientable: {conflicts} edges have faces wound against each other"
        )


def _remarks(shape: Shape) -> tuple[str, ...]:
    remarks = []
    boundary = int((edge_face_counts(shape.faces) == 1).sum())
    if boundary:
        remarks.append(f"open boundary of {boundary} edges: scans may show its inside")
    unused = len(shape.vertices) - len(np.unique(shape.faces))
    if unused:
        remarks.append(f"{unused} vertices belong to no face")
    if looks_inward(shape.vertices, shape.faces):
        remarks.append("faces look inward")
    return tuple(remarks)


def oriented(faces: NDArray[np.int32], vertices: NDArray[np.float64], name: str) -> NDArray[np.int32]:
    """Faces wound consistently and outward, with a log line for each change.

    Parameters
    ----------
    faces : (f, 3)
    vertices : (v, 3)
        Of the pose by which "outward" is decided.
    name
        For the log.

    Returns
    -------
    (f, 3) int32
        The same faces in the same order; only the order of corners within a face may differ.
    """
    conflicts = winding_conflicts(faces)
    if conflicts and (edge_face_counts(faces) <= 2).all():
        import trimesh  # where it is needed: a start without it takes half as long

        mesh = trimesh.Trimesh(vertices, faces, process=False)
        trimesh.repair.fix_winding(mesh)
        faces = np.asarray(mesh.faces, dtype=np.int32)
        _log.warning("%s: %d edges had faces wound against each other; made consistent", name, conflicts)
    if looks_inward(vertices, faces):
        faces = np.ascontiguousarray(faces[:, ::-1])
        _log.warning("%s: faces looked inward; flipped", name)
    return faces


def sound_part(shapes: list[Shape]) -> tuple[NDArray[np.int64], NDArray[np.int32]]:
    """What is left of poses that share their faces, without what `repaired` drops.

    Returns
    -------
    used : (w,)
        Vertices that are kept.
    faces : (f, 3)
        Of `used`.
    """
    for shape in shapes:
        _check_arrays(shape)
    faces = shapes[0].faces
    flat = np.logical_and.reduce([flat_faces(shape) for shape in shapes]) | repeated_corners(faces)
    first = np.zeros(len(faces), dtype=bool)
    first[np.unique(np.sort(faces, axis=1), axis=0, return_index=True)[1]] = True
    keep = ~flat & first
    if not keep.any():
        raise InputError(f"{shapes[0].name!r} has only degenerate faces; export it again")
    labels = face_components(faces[keep])
    used, compact = np.unique(faces[keep][labels == np.bincount(labels).argmax()], return_inverse=True)
    return used.astype(np.int64), compact.reshape(-1, 3).astype(np.int32)


def repaired(shapes: list[Shape]) -> list[Shape]:
    """Drop what can be dropped from poses that share their faces, with a log line.

    Removes faces that name a vertex twice, repeat another face or have no area in any pose, keeps the
    largest component, and drops vertices that are then unused, in every pose alike.
    """
    used, faces = sound_part(shapes)
    before = shapes[0]
    if len(used) == len(before.vertices) and len(faces) == len(before.faces):
        return shapes
    _log.warning(
        "%s: kept %d of %d faces and %d of %d vertices (largest component, no degenerate or repeated faces)",
        before.subject, len(faces), len(before.faces), len(used), len(before.vertices),
    )  # fmt: skip
    return [replace(shape, vertices=shape.vertices[used], faces=faces) for shape in shapes]


def admitted(shapes: list[Shape], repair: bool = False) -> list[Shape]:
    """Check poses that share their faces, and wind the faces outward; remarks go to the log.

    Parameters
    ----------
    shapes
        The first decides what is outward.
    repair
        Apply `repaired` first, and accept faces that lose their area in some of the poses.

    Raises
    ------
    InputError
        As `check_mesh`.
    """
    for shape in shapes:
        _check_arrays(shape)
    if repair:
        shapes = repaired(shapes)
    faces = oriented(shapes[0].faces, shapes[0].vertices, shapes[0].name)
    shapes = [replace(shape, faces=faces) for shape in shapes]
    for shape in shapes:
        remarks = check_mesh(shape, allow_flat=repair)
        if remarks:
            _log.warning("%s: %s", shape.name, "; ".join(remarks))
    return shapes


def scannable(shape: Shape, repair: bool = False) -> Shape:
    """A mesh for the scanner alone, which needs a surface and nothing else; remarks go to the log.

    Any number of components, open boundaries, edges of more than two faces, vertices off the surface and
    faces without area are allowed. The faces are wound outward and against each other as by `admitted`, but
    for those without area.

    Parameters
    ----------
    shape
    repair
        Apply `repaired` first.

    Raises
    ------
    InputError
        For no faces, vertex ids out of range, coordinates of the faces that are not finite, or no area.
    """
    _check_ids(shape)
    _check_finite(shape, np.unique(shape.faces))
    if repair:
        shape = repaired([shape])[0]
    solid = solid_faces(shape.vertices, shape.faces)
    if not solid.any():
        raise InputError(f"{shape.name!r} has only degenerate faces (no area); export it again")
    wound = oriented(shape.faces[solid], shape.vertices, shape.name)
    faces = shape.faces.copy()
    faces[solid] = wound
    remarks = _remarks(replace(shape, faces=wound))
    if flat := len(faces) - len(wound):
        remarks = (f"{flat} degenerate faces (no area) are ignored", *remarks)
    parts = len(np.unique(face_components(wound)))
    if parts > 1:
        remarks = (f"{parts} pieces", *remarks)
    if remarks:
        _log.warning("%s: %s", shape.name, "; ".join(remarks))
    return shape if np.array_equal(faces, shape.faces) else replace(shape, faces=faces)
