"""PFARM and CP2P: ``shapes/`` and ``maps/A_B.map``, for each vertex of A a vertex of B, from 0.

Or ``maps/A_B.corr``, for truth within triangles, such as BeCoS has: for each vertex of A a triangle of B,
from 1, and three weights, ``-1 0 0 0`` for none.
"""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.collection import Collection
from datasets_gen.collections.file_choice import chosen, files_of
from datasets_gen.collections.placing import placed_by_ids, spread
from datasets_gen.collections.sound_poses import sound_poses
from datasets_gen.correspondences.point_map import PointMap
from datasets_gen.correspondences.reading import read_map
from datasets_gen.mesh_placement import MeshPlacement
from datasets_gen.meshes.files import MESH_SUFFIXES, read_mesh
from datasets_gen.meshes.mirroring import mirror_map
from datasets_gen.meshes.nearest_faces import nearest_on_mesh
from datasets_gen.records import InputError
from datasets_gen.shape import Shape

SHAPES, MAPS = "shapes", "maps"


def recognises(folder: Path) -> bool:
    """Whether there are shapes and maps."""
    return (folder / SHAPES).is_dir() and (folder / MAPS).is_dir()


def outline(
    folder: str | os.PathLike[str], *, reference: str | None = None, poses: Sequence[str] | None = None
) -> dict[str, Any]:
    """Subject, poses and reference that `load` would give, from the names of the files.

    Parameters
    ----------
    folder, reference, poses
        As for `load`.
    """
    _, maps, rest = _files(Path(folder), reference)
    subject = Path(folder).resolve().name
    wanted, _ = chosen([rest, *maps], subject, poses, None)
    return {"subject": subject, "poses": wanted, "reference": rest}


def load(
    folder: str | os.PathLike[str], *, reference: str | None = None, poses: Sequence[str] | None = None
) -> Collection:
    """Load a shape and all that are mapped to it.

    Parameters
    ----------
    folder
    reference
        Shape B of the maps that are used. Default: the one that most maps lead to, the first of several.
    poses
        Names of shapes. Default: the reference and all that have a map to it.

    Raises
    ------
    InputError
        If a file cannot be used, or a map does not fit its shapes.
    """
    root = Path(folder)
    files, maps, rest = _files(root, reference)
    subject = root.resolve().name
    wanted, _ = chosen([rest, *maps], subject, poses, None)
    raw = {pose: _read(files[pose], subject, pose) for pose in dict.fromkeys([rest, *wanted])}
    (target,), kept, remarks = sound_poses([raw[rest]], fill=False)
    place = np.full(len(raw[rest].vertices) + 1, -1, dtype=np.int64)  # the last stays: no match
    place[kept] = np.arange(len(kept))
    found, placements = {rest: target}, {}
    for pose in wanted:
        if pose != rest:
            found_map = read_map(maps[pose])
            if len(found_map) != len(raw[pose].vertices):
                raise InputError(
                    f"{str(maps[pose])!r} has {len(found_map)} rows, {files[pose].name!r} "
                    f"{len(raw[pose].vertices)} vertices; rows are vertices of the first shape of its name"
                )
            found_map.check_target(len(raw[rest].vertices), len(raw[rest].faces), repr(str(maps[pose])))
            (shape,), own, said = sound_poses([raw[pose]], fill=False)
            placements[pose], lost = _placed(found_map, own, shape, place, raw[rest], target)
            found[pose] = shape
            remarks += said
            if lost:
                remarks.append(f"{shape.name}: {lost} vertices without a match: placed by their neighbours")
    shapes = tuple(found[pose] for pose in wanted)
    return Collection(subject, shapes, target, mirror_map(target), placements, tuple(remarks))


def _placed(
    found: PointMap,
    own: NDArray[np.int64],
    shape: Shape,
    place: NDArray[np.int64],
    raw: Shape,
    target: Shape,
) -> tuple[MeshPlacement, int]:
    """Where a shape lies on the reference by its map, and how many vertices are placed by neighbours."""
    if found.weights is None:
        return placed_by_ids(shape, place[found.ids[own]], target)
    ids, weights = found.ids[own], found.weights[own]
    nearest = spread(shape, np.where(ids >= 0, np.arange(len(ids)), -1))
    points = raw.at(ids[nearest], weights[nearest] / weights[nearest].sum(axis=1, keepdims=True))
    return MeshPlacement(*nearest_on_mesh(target.vertices, target.faces, points)), int((ids < 0).sum())


def _files(folder: Path, reference: str | None) -> tuple[dict[str, Path], dict[str, Path], str]:
    """Meshes by shape, maps to the reference by their first shape, and the reference."""
    files = files_of(folder / SHAPES, MESH_SUFFIXES)
    if not files:
        raise InputError(f"{str(folder / SHAPES)!r} holds no meshes ({', '.join(MESH_SUFFIXES)})")
    if reference is not None and reference not in files:
        raise InputError(f"{str(folder / SHAPES)!r} has no shape {reference!r}; it has {', '.join(files)}")
    leading: dict[str, dict[str, Path]] = {name: {} for name in files}
    for stem, file in files_of(folder / MAPS, (".map", ".corr")).items():
        for target in files:
            source = stem.removesuffix(f"_{target}")
            if source in files and source != target and source != stem:
                leading[target][source] = file
    rest = reference or max(files, key=lambda name: len(leading[name]))
    if not leading[rest]:
        wanted = f"A_{rest}.map" if reference else "A_B.map"
        raise InputError(
            f"{str(folder / MAPS)!r} has no map between two of the shapes that fits ({wanted}, named by the "
            "files of its shapes)"
        )
    return files, leading[rest], rest


def _read(file: Path, subject: str, pose: str) -> Shape:
    mesh = read_mesh(file, subject)
    return Shape(mesh.vertices, mesh.faces, f"{subject}/{pose}", subject, pose)
