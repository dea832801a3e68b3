"""Remeshed sets (SCAPE_r, FAUST_r, TOSCA_r): meshes and ``corres/*.vts``, each shape with its own mesh.

The meshes are in ``off/``, or beside ``corres/`` as in the sets' own repository. Row i of ``corres/x.vts`` is
the vertex of ``x.off``, from 1, at point i of a template that all shapes of
a subject have in common; ``x.sym.vts`` is the same for the mirror images of the template's points.
"""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.collection import Collection
from datasets_gen.collections.file_choice import chosen, class_of, files_of, one_subject
from datasets_gen.collections.placing import placed_by_ids, spread
from datasets_gen.collections.sound_poses import sound_poses
from datasets_gen.correspondences.reading import read_map
from datasets_gen.meshes.files import MESH_SUFFIXES, read_mesh
from datasets_gen.meshes.mirroring import mirror_map
from datasets_gen.records import InputError
from datasets_gen.shape import Shape

MESHES, MAPS = "off", "corres"


def recognises(folder: Path) -> bool:
    """Whether there are meshes and correspondences."""
    if not (folder / MAPS).is_dir():
        return False
    beside = any(file.suffix.lower() in MESH_SUFFIXES for file in folder.iterdir())
    return (folder / MESHES).is_dir() or (beside and any((folder / MAPS).glob("*.vts")))


def _meshes(folder: Path) -> Path:
    """Where the meshes are."""
    return folder / MESHES if (folder / MESHES).is_dir() else folder


def outline(
    folder: str | os.PathLike[str],
    *,
    subject: str | None = None,
    poses: Sequence[str] | None = None,
    reference: str | None = None,
) -> dict[str, Any]:
    """Subject, poses and reference that `load` would give, from the names of the files.

    Parameters
    ----------
    folder, subject, poses, reference
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
) -> Collection:
    """Load the shapes of one subject; each lies on the reference by the template.

    Ground truth is as fine as the vertices: a vertex lies at the vertex of the reference that has the same
    template point; one that has none takes the place of the nearest along the mesh that has one.

    Parameters
    ----------
    folder
    subject
        What the names of the files have before their numbers, such as ``"cat"``; may be left out if all have
        the same.
    poses, reference
        Names such as ``"cat10"``. Default: all, and the first.

    Raises
    ------
    InputError
        If a file cannot be used, or maps differ in length.
    """
    root = Path(folder)
    name, files = _files(root, subject)
    wanted, rest = chosen(list(files), name, poses, reference)
    found, placements, remarks = dict[str, Shape](), {}, []
    template, mirror = np.empty(0, dtype=np.int64), None
    for pose in dict.fromkeys([rest, *wanted]):
        mesh = read_mesh(files[pose], name)
        raw = Shape(mesh.vertices, mesh.faces, f"{name}/{pose}", name, pose)
        (shape,), kept, said = sound_poses([raw], fill=False)
        remarks += said
        points = _template(root / MAPS / f"{pose}.vts", raw, kept)
        found[pose] = shape
        if pose == rest:
            template = points
            mirror = _mirror(root / MAPS / f"{pose}.sym.vts", raw, shape, points, kept)
            continue
        if len(points) != len(template):
            raise InputError(
                f"{str(root / MAPS / pose)!r}.vts has {len(points)} rows, {rest}.vts {len(template)}; rows "
                "are the points of one template, choose shapes of one subject"
            )
        ids = np.full(len(shape.vertices), -1, dtype=np.int64)
        both = (points >= 0) & (template >= 0)
        ids[points[both][::-1]] = template[both][::-1]  # of several template points, the first counts
        placements[pose], lost = placed_by_ids(shape, ids, found[rest])
        if lost:
            remarks.append(f"{shape.name}: {lost} vertices of no template point: placed by neighbours")
    shapes = tuple(found[pose] for pose in wanted)
    return Collection(name, shapes, found[rest], mirror, placements, tuple(remarks))


def _files(folder: Path, subject: str | None) -> tuple[str, dict[str, Path]]:
    """Name of the subject and the mesh of each pose."""
    subjects: dict[str, dict[str, Path]] = {}
    for stem, file in files_of(_meshes(folder), MESH_SUFFIXES).items():
        subjects.setdefault(class_of(stem), {})[stem] = file
    if not subjects:
        raise InputError(f"{str(_meshes(folder))!r} holds no meshes ({', '.join(MESH_SUFFIXES)})")
    return one_subject(subjects, subject, folder)


def _template(path: Path, raw: Shape, kept: NDArray[np.int64]) -> NDArray[np.int64]:
    """Vertex of the shape as it is used at each template point; -1 where it was dropped."""
    if not path.is_file():
        raise InputError(f"{str(path)!r} is missing; it says which vertex lies at each template point")
    points = read_map(path, first_id=1)
    lost = np.flatnonzero(~points.matched)
    if len(lost):
        raise InputError(
            f"{str(path)!r}: row {lost[0] + 1} names no vertex; a .vts counts from 1, add 1 to indices from 0"
        )
    if points.ids.max(initial=-1) >= len(raw.vertices):
        raise InputError(
            f"{str(path)!r} names vertex {points.ids.max() + 1} of {len(raw.vertices)}; rows are template "
            "points and entries vertices of this shape, from 1"
        )
    place = np.full(len(raw.vertices), -1, dtype=np.int64)
    place[kept] = np.arange(len(kept))
    return place[points.ids]


def _mirror(
    path: Path, raw: Shape, shape: Shape, template: NDArray[np.int64], kept: NDArray[np.int64]
) -> NDArray[np.int64] | None:
    """The vertex that mirrors each vertex, by the file if there is one, else by the shape."""
    if not path.is_file():
        return mirror_map(shape)
    images = _template(path, raw, kept)
    if len(images) != len(template):
        raise InputError(f"{str(path)!r} has {len(images)} rows, the .vts without sym {len(template)}")
    ids, both = np.full(len(shape.vertices), -1, dtype=np.int64), (images >= 0) & (template >= 0)
    ids[template[both][::-1]] = images[both][::-1]
    return spread(shape, ids)
