"""SHREC'16 Partial: parts of posed shapes in ``cuts/`` and ``holes/``, the full shapes in ``null/``.

``cuts_cat_shape_3.off`` comes with ``cuts_cat_shape_3.baryc_gt``: for each vertex a triangle of
``null/cat.off``, from 1, and three weights.
"""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from datasets_gen.collection import Collection
from datasets_gen.collections.file_choice import chosen, files_of, one_subject
from datasets_gen.collections.sound_poses import sound_poses
from datasets_gen.correspondences.reading import read_map
from datasets_gen.mesh_placement import MeshPlacement
from datasets_gen.meshes.files import read_mesh
from datasets_gen.meshes.mirroring import mirror_map
from datasets_gen.meshes.nearest_faces import nearest_on_mesh
from datasets_gen.records import InputError
from datasets_gen.shape import Shape

KINDS = ("cuts", "holes")
NULL = "null"


def recognises(folder: Path) -> bool:
    """Whether there are full shapes and parts."""
    return (folder / NULL).is_dir() and any((folder / kind).is_dir() for kind in KINDS)


def outline(
    folder: str | os.PathLike[str],
    *,
    subject: str | None = None,
    kind: str | None = None,
    poses: Sequence[str] | None = None,
) -> dict[str, Any]:
    """Subject, poses and reference that `load` would give, from the names of the files.

    Parameters
    ----------
    folder, subject, kind, poses
        As for `load`.
    """
    name, files = _files(Path(folder), subject, kind)
    wanted, rest = chosen(list(files), name, poses, None)
    return {"subject": name, "poses": wanted, "reference": rest}


def load(
    folder: str | os.PathLike[str],
    *,
    subject: str | None = None,
    kind: str | None = None,
    poses: Sequence[str] | None = None,
) -> Collection:
    """Load a full shape, pose ``"null"``, and its parts, which lie on it by their ``.baryc_gt``.

    Parameters
    ----------
    folder
    subject
        Such as ``"cat"``; may be left out if there is one.
    kind
        ``"cuts"`` or ``"holes"``. Default: both.
    poses
        Such as ``["null", "cuts-3"]``. Default: all.

    Raises
    ------
    InputError
        If a file cannot be used or a part has no ground truth.
    """
    name, files = _files(Path(folder), subject, kind)
    wanted, rest = chosen(list(files), name, poses, None)
    full = _read(files[rest], name, rest)
    (null,), _, remarks = sound_poses([full], fill=False)
    found, placements = {rest: null}, {}
    for pose in wanted:
        if pose != rest:
            part = _read(files[pose], name, pose)
            placement = _placement(files[pose], part, full, null)
            (found[pose],), kept, said = sound_poses([part], fill=False)
            placements[pose] = MeshPlacement(placement.face_ids[kept], placement.barycentrics[kept])
            remarks += said
    shapes = tuple(found[pose] for pose in wanted)
    return Collection(name, shapes, null, mirror_map(null), placements, tuple(remarks))


def _files(folder: Path, subject: str | None, kind: str | None) -> tuple[str, dict[str, Path]]:
    """Name of the subject and the file of each pose."""
    if kind not in (None, *KINDS):
        raise InputError(f"kind is {kind!r}; choose {' or '.join(KINDS)}, or leave it out for both")
    nulls = files_of(folder / NULL, (".off", ".ply", ".obj"))
    if not nulls:
        raise InputError(f"{str(folder / NULL)!r} holds no meshes; it has the full shapes, such as cat.off")
    name, full = one_subject(nulls, subject, folder)
    files = {NULL: full}
    for each in KINDS if kind is None else (kind,):
        if (folder / each).is_dir():
            for stem, file in files_of(folder / each, (".off", ".ply", ".obj")).items():
                if stem.startswith(f"{each}_{name}_"):
                    files[f"{each}-{stem.rpartition('_')[2]}"] = file
    return name, files


def _read(file: Path, subject: str, pose: str) -> Shape:
    mesh = read_mesh(file, subject)
    return Shape(mesh.vertices, mesh.faces, f"{subject}/{pose}", subject, pose)


def _placement(file: Path, part: Shape, full: Shape, null: Shape) -> MeshPlacement:
    """Where each vertex of a part's file lies on the full shape as it is used."""
    truth = file.with_suffix(".baryc_gt")
    if not truth.is_file():
        raise InputError(
            f"{str(file)!r} has no {truth.name} beside it, which says where its vertices lie; add it, "
            "or choose other poses"
        )
    places = read_map(truth)
    if len(places) != len(part.vertices):
        raise InputError(
            f"{str(truth)!r} has {len(places)} rows, {file.name!r} {len(part.vertices)} vertices; "
            "take both from one archive"
        )
    lost = np.flatnonzero(~places.matched)
    if len(lost) or places.weights is None:
        raise InputError(
            f"{str(truth)!r}: row {lost[0] + 1} names no triangle; triangles count from 1, take the file anew"
        )
    places.check_target(len(full.vertices), len(full.faces), repr(str(truth)))
    weights = np.clip(places.weights, 0, None)
    weights /= weights.sum(axis=1, keepdims=True)
    if np.array_equal(full.faces, null.faces):
        return MeshPlacement(places.ids.astype(np.int32), weights)
    return MeshPlacement(*nearest_on_mesh(null.vertices, null.faces, full.at(places.ids, weights)))
