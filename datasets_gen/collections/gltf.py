"""Characters of glTF files, ``.glb`` or ``.gltf``: a skin posed by the animations in the file.

Poses are taken at evenly spaced times of each animation, by linear blend skinning and morph targets as the
format defines them. Vertex i is the same place of the skin in every pose, so truth is exact.
"""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.collection import Collection
from datasets_gen.collections.closing import uncrowded
from datasets_gen.collections.file_choice import pose_list
from datasets_gen.collections.gltf_buffers import GltfFile
from datasets_gen.collections.gltf_motion import Changes, Track, animation_names, tracks_of
from datasets_gen.collections.gltf_skin import RiggedMesh, rigged_mesh
from datasets_gen.collections.sound_poses import sound_poses
from datasets_gen.meshes.mirroring import mirror_map
from datasets_gen.records import InputError
from datasets_gen.shape import Shape
from datasets_gen.values import check_count

REST = "rest"
FRAMES = 8
MOST_FRAMES = 1000
MOST_CUT_OUT = 0.05
"""Largest share of the faces that may lie at edges of more than two faces, which are cut out."""
LOOP = 1e-3
"""Largest distance, over the diagonal, of a vertex from where it began, for the end of a loop."""


def outline(
    path: str | os.PathLike[str],
    *,
    animations: Sequence[str] | None = None,
    frames: int = FRAMES,
    poses: Sequence[str] | None = None,
    fill: bool = True,
) -> dict[str, Any]:
    """Subject, poses and reference that `load` would give, from the names of the animations.

    Parameters
    ----------
    path, animations, frames, poses, fill
        As for `load`.
    """
    file = GltfFile.read(Path(path))
    return _outlined(file, animations, frames, poses)


def load(
    path: str | os.PathLike[str],
    *,
    animations: Sequence[str] | None = None,
    frames: int = FRAMES,
    poses: Sequence[str] | None = None,
    fill: bool = True,
) -> Collection:
    """Load a character in the poses of its animations.

    All meshes of the scene are joined, and vertices at one place that move alike are welded. Few faces at
    edges of more than two faces are cut out; of what then hangs together the largest piece is kept. The
    reference is the pose in which the file stands, ``rest``.

    Parameters
    ----------
    path
        A ``.glb``, or a ``.gltf`` with its buffers beside it.
    animations
        Names of those to use. Default: all.
    frames
        Poses of each, ``walk-1`` to ``walk-8``, evenly spaced from its first key to its last; of one that
        ends as it begins, the end is left out.
    poses
        Names, default all and ``rest``.
    fill
        Whether small holes are filled.

    Raises
    ------
    InputError
        If the file is damaged, compressed or without a mesh, or lacks an animation or a pose asked for.
    """
    file = GltfFile.read(Path(path))
    told = _outlined(file, animations, frames, poses)
    subject, mesh = told["subject"], rigged_mesh(file)
    posed = {REST: mesh.posed({})}
    names = animation_names(file)
    for name in names if animations is None else animations:
        if any(_pose(name, k) in told["poses"] for k in range(frames)):
            tracks = tracks_of(file, names.index(name))
            posed |= {
                _pose(name, k): each for k, each in enumerate(_frames(mesh, tracks, frames, posed[REST]))
            }
    wanted = [REST, *(pose for pose in told["poses"] if pose != REST)]
    faces = uncrowded(mesh.faces).astype(np.int32)
    cut_out = len(mesh.faces) - len(faces)
    if cut_out > MOST_CUT_OUT * len(mesh.faces):
        raise InputError(
            f"{str(path)!r} has edges of more than two faces all over ({cut_out:,} of {len(mesh.faces):,} "
            "faces lie at them); join the surfaces or export the body alone"
        )
    shapes = [Shape(posed[pose], faces, f"{subject}/{pose}", subject, pose, "m") for pose in wanted]
    sound, _, remarks = sound_poses(shapes, fill=fill)
    found = dict(zip(wanted, sound, strict=True))
    chosen = tuple(found[pose] for pose in told["poses"])
    said = [f"{subject}: {remark}" for remark in mesh.remarks]
    said += [f"{subject}: {cut_out:,} faces at edges of more than two faces: cut out"] if cut_out else []
    said += [] if names else [f"{subject}: no animations, so {REST!r} is the only pose"]
    return Collection(subject, chosen, found[REST], mirror_map(found[REST]), remarks=(*said, *remarks))


def files_of_gltf(path: Path) -> list[Path]:
    """The file and those beside it that it is made of."""
    return GltfFile.read(path).files()


def _outlined(
    file: GltfFile, animations: Sequence[str] | None, frames: int, poses: Sequence[str] | None
) -> dict[str, Any]:
    subject, names = file.path.stem, animation_names(file)
    if check_count(frames, f"frames of {subject!r}") > MOST_FRAMES:
        raise InputError(f"frames of {subject!r} is {frames}; give at most {MOST_FRAMES}")
    if animations is not None:
        listed = not isinstance(animations, str) and isinstance(animations, Sequence)
        lost = [name for name in animations if name not in names] if listed else [animations]
        if lost:
            raise InputError(f"{subject!r} has no animations {lost[0]!r}; give a list of {names}")
    used = names if animations is None else list(dict.fromkeys(animations))
    known = [REST, *(_pose(name, k) for name in used for k in range(frames))]
    wanted = known if poses is None else pose_list(poses, known, subject)
    return {"subject": subject, "poses": wanted, "reference": REST}


def _pose(animation: str, frame: int) -> str:
    return f"{animation}-{frame + 1}"


def _frames(
    mesh: RiggedMesh, tracks: list[Track], frames: int, rest: NDArray[np.float64]
) -> list[NDArray[np.float64]]:
    """Vertices (v, 3) at evenly spaced times of an animation."""
    if not tracks:
        return [rest] * frames
    first, last = min(track.times[0] for track in tracks), max(track.times[-1] for track in tracks)

    def at(time: float) -> NDArray[np.float64]:
        changes: Changes = {(track.node, track.path): track.at(time) for track in tracks}
        return mesh.posed(changes)

    away = np.linalg.norm(at(last) - at(first), axis=1).max(initial=0)
    loops = frames > 1 and away <= LOOP * np.linalg.norm(np.ptp(rest, axis=0))
    return [at(time) for time in np.linspace(first, last, frames, endpoint=not loops)]
