"""TOSCA: poses of animals and people, ``cat0.mat``, ``cat0.vert`` with ``cat0.tri``, or ``cat0.off``.

Vertex i of one class is the same surface point in every file, whatever the order of the faces.
"""

import os
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.collection import Collection
from datasets_gen.collections.file_choice import chosen, class_of, files_of, one_subject
from datasets_gen.collections.number_rows import number_rows
from datasets_gen.collections.placing import placed_by_ids
from datasets_gen.collections.sound_poses import sound_poses
from datasets_gen.matlab_files import read_matlab
from datasets_gen.meshes.files import read_mesh
from datasets_gen.meshes.mirroring import mirror_map
from datasets_gen.records import InputError
from datasets_gen.shape import Shape

CLASSES = (
    "cat", "centaur", "david", "dog", "gorilla", "horse", "lioness", "michael", "seahorse", "shark",
    "victoria", "wolf",
)  # fmt: skip
SUFFIXES = (".mat", ".vert", ".off", ".ply", ".obj")


def recognises(folder: Path) -> bool:
    """Whether every mesh is called like a class of TOSCA and a number, or the files are of its own kinds."""
    files = [file for file in folder.iterdir() if file.suffix.lower() in SUFFIXES]
    if any(file.suffix.lower() == ".vert" for file in files):
        return True
    return bool(files) and all(
        re.fullmatch(r"[A-Za-z_-]+\d+", file.stem)
        and (file.suffix.lower() == ".mat" or class_of(file.stem).lower() in CLASSES)
        for file in files
    )


def outline(
    folder: str | os.PathLike[str],
    *,
    subject: str | None = None,
    poses: Sequence[str] | None = None,
    reference: str | None = None,
    fill: bool = True,
) -> dict[str, Any]:
    """Subject, poses and reference that `load` would give, from the names of the files.

    Parameters
    ----------
    folder, subject, poses, reference, fill
        As for `load`.
    """
    name, files = _files(Path(folder), subject)
    wanted, rest = chosen(list(files), name, poses, reference)
    return {"subject": name, "poses": wanted, "reference": rest}


def load(
    folder: str | os.PathLike[str],
    *,
    subject: str | None = None,
    poses: Sequence[str] | None = None,
    reference: str | None = None,
    fill: bool = True,
) -> Collection:
    """Load one class.

    The faces of the reference serve a pose that has the same ones in another order; a pose with other faces
    keeps them and lies on the reference by its vertices. Coordinates stay as they are: z is up.

    Parameters
    ----------
    folder
    subject
        Class, such as ``"cat"``; may be left out if there is one.
    poses, reference
        Names such as ``"cat10"``. Default: all, and the one of the lowest number.
    fill
        Whether small holes, such as open eyes, are filled.

    Raises
    ------
    InputError
        If a file cannot be used, or the numbers of vertices differ.
    """
    root = Path(folder)
    name, files = _files(root, subject)
    wanted, rest = chosen(list(files), name, poses, reference)
    shapes = {pose: _read(files[pose], name) for pose in dict.fromkeys([rest, *wanted])}
    first = shapes[rest]
    for pose, shape in shapes.items():
        if len(shape.vertices) != len(first.vertices):
            raise InputError(
                f"{str(files[pose])!r} has {len(shape.vertices)} vertices, {files[rest].name!r} "
                f"{len(first.vertices)}; poses of one class have the same, replace the file"
            )
    alike = {pose: replace(shape, faces=first.faces) for pose, shape in shapes.items() if _same(shape, first)}
    sound, kept, remarks = sound_poses(list(alike.values()), fill=fill)
    found, placements = dict(zip(alike, sound, strict=True)), {}
    ids = np.full(len(first.vertices), -1, dtype=np.int64)
    ids[kept] = np.arange(len(kept))
    for pose in shapes.keys() - alike.keys():
        (own,), places, said = sound_poses([shapes[pose]], fill=fill)
        found[pose], placements[pose] = own, placed_by_ids(own, ids[places], found[rest])[0]
        remarks += [*said, f"{own.name}: other faces than {rest!r}; placed on it by its vertices"]
    chosen_shapes = tuple(found[pose] for pose in wanted)
    return Collection(name, chosen_shapes, found[rest], mirror_map(found[rest]), placements, tuple(remarks))


def _files(folder: Path, subject: str | None) -> tuple[str, dict[str, Path]]:
    """Name of the class, and the file of each pose by its name."""
    classes: dict[str, dict[str, Path]] = {}
    for stem, file in files_of(folder, SUFFIXES).items():
        classes.setdefault(class_of(stem), {})[stem] = file
    return one_subject(classes, subject, folder)


def _same(shape: Shape, first: Shape) -> bool:
    """Whether two meshes have the same faces in any order, each from any corner."""
    if len(shape.faces) != len(first.faces):
        return False
    a, b = (np.sort(each.faces, axis=1) for each in (shape, first))
    return bool(np.array_equal(a[np.lexsort(a.T)], b[np.lexsort(b.T)]))


def _read(file: Path, subject: str) -> Shape:
    """One pose, named."""
    suffix = file.suffix.lower()
    if suffix == ".mat":
        vertices, faces = _matlab(file)
    elif suffix == ".vert":
        vertices, faces = _text(file)
    else:
        mesh = read_mesh(file, subject)
        vertices, faces = mesh.vertices, mesh.faces.astype(np.int64)
    return Shape(vertices, faces.astype(np.int32), f"{subject}/{file.stem}", subject, file.stem)


def _matlab(file: Path) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Vertices and faces of ``surface.X``, ``.Y``, ``.Z`` and ``.TRIV``, which counts from 1."""
    surface = read_matlab(file).get("surface")
    fields = (surface.dtype.names or ()) if isinstance(surface, np.ndarray) else ()
    lacking = [name for name in ("X", "Y", "Z", "TRIV") if name not in fields]
    if surface is None or lacking or surface.size != 1:
        missing = ", ".join(f"surface.{name}" for name in lacking) or "a single surface"
        raise InputError(f"{str(file)!r} lacks {missing}; TOSCA's files have surface.X, .Y, .Z and .TRIV")
    entry = surface.ravel()[0]
    try:
        columns = [np.asarray(entry[name], dtype=np.float64).ravel() for name in "XYZ"]
        vertices, faces = np.column_stack(columns), np.asarray(entry["TRIV"], dtype=np.float64)
    except (TypeError, ValueError) as error:
        raise InputError(f"{str(file)!r}: surface.X, .Y, .Z differ in length or are no numbers") from error
    if faces.ndim != 2 or faces.shape[1] != 3 or not (faces == np.round(faces)).all():
        raise InputError(f"{str(file)!r}: surface.TRIV is no table of three whole numbers a row")
    wrong = (faces < 1) | (faces > len(vertices))
    if wrong.any():
        raise InputError(
            f"{str(file)!r}: surface.TRIV names vertex {faces[wrong][0]:g}, but counts from 1 to "
            f"{len(vertices)}; export it again"
        )
    return vertices, faces.astype(np.int64) - 1


def _text(file: Path) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Vertices and faces of a ``.vert`` and the ``.tri`` beside it, whose base its indices tell."""
    partner = next((p for p in (file.with_suffix(".tri"), file.with_suffix(".TRI")) if p.is_file()), None)
    if partner is None:
        raise InputError(f"{str(file)!r} has no {file.stem}.tri beside it, which has its faces; add it")
    vertices, faces = number_rows(file, 3), number_rows(partner, 3, whole=True).astype(np.int64)
    low, high, count = int(faces.min(initial=1)), int(faces.max(initial=0)), len(vertices)
    if low < 0 or high > count or high - low >= count:
        raise InputError(
            f"{str(partner)!r} names vertices {low} to {high}, but {file.name!r} has {count}; "
            "take both from one archive"
        )
    if low > 0 and high < count:
        raise InputError(
            f"{str(partner)!r} names vertices {low} to {high} of {count}, which does not tell whether they "
            "count from 0 or 1; remove the vertices of no face from the .vert, or give the mesh as .off"
        )
    return vertices, faces - 1 if high == count else faces
