"""Frames of a capture, a folder of numbered meshes each with faces of its own: shapes without ground truth.

Multi-view reconstructions come like this, as those of [VPB*09] that the paper matches. Nothing tells which
places of two frames correspond, so they can be shown, scanned and matched, but not scored.

References
----------
[VPB*09] D. Vlasic et al., "Dynamic shape capture using multi-view photometric stereo", SIGGRAPH Asia 2009.
"""

import os
import re
from collections.abc import Sequence
from itertools import islice
from pathlib import Path
from typing import Any

from datasets_gen.checks import scannable
from datasets_gen.collection import Collection
from datasets_gen.collections.file_choice import chosen, class_of, files_of
from datasets_gen.collections.load_report import mesh_report
from datasets_gen.meshes.files import MESH_SUFFIXES, read_mesh
from datasets_gen.shape import Shape

HEADER_LINES = 200


def recognises(folder: Path) -> bool:
    """Whether all meshes have one name but for a number, and some have other numbers of vertices or faces."""
    files = [file for file in folder.iterdir() if file.suffix.lower() in MESH_SUFFIXES and file.is_file()]
    stems = [file.stem for file in files]
    if len(set(stems)) < max(len(stems), 2) or not all(re.search(r"\d$", stem) for stem in stems):
        return False
    return len({class_of(stem) for stem in stems}) == 1 and len({mesh_counts(file) for file in files}) > 1


def outline(
    folder: str | os.PathLike[str],
    *,
    poses: Sequence[str] | None = None,
    reference: str | None = None,
    units: str | None = None,
) -> dict[str, Any]:
    """Subject, poses and reference that `load` would give, from the names of the files.

    Parameters
    ----------
    folder, poses, reference, units
        As for `load`.

    Returns
    -------
    dict
        As `datasets_gen.registry.outline`, with ``truth``, which is False.
    """
    subject = Path(folder).resolve().name
    wanted, rest = chosen(list(files_of(Path(folder), MESH_SUFFIXES)), subject, poses, reference)
    return {"subject": subject, "poses": wanted, "reference": rest, "truth": False}


def load(
    folder: str | os.PathLike[str],
    *,
    poses: Sequence[str] | None = None,
    reference: str | None = None,
    units: str | None = None,
) -> Collection:
    """Load frames as they are, without ground truth.

    Pieces, holes and whatever else a reconstruction leaves stay; faces are wound outward where that can be
    told.

    Parameters
    ----------
    folder
    poses, reference
        Names of files without their endings. Default: all, and the first.
    units
        Length unit. Default: unknown.

    Raises
    ------
    InputError
        If a file cannot be used.
    """
    told, files = outline(folder, poses=poses, reference=reference), files_of(Path(folder), MESH_SUFFIXES)
    subject, shapes, remarks = told["subject"], dict[str, Shape](), list[str]()
    for pose in dict.fromkeys([told["reference"], *told["poses"]]):
        read = read_mesh(files[pose], subject, units or "unknown")
        shapes[pose] = scannable(
            Shape(read.vertices, read.faces, f"{subject}/{pose}", subject, pose, read.units)
        )
        remarks += [f"{subject}/{pose}: {remark}" for remark in mesh_report(shapes[pose])]
    remarks.append(
        f"{subject}: no ground truth, as the frames have meshes of their own; nothing can be scored"
    )
    frames = tuple(shapes[pose] for pose in told["poses"])
    return Collection(subject, frames, shapes[told["reference"]], remarks=tuple(remarks), truth=False)


def mesh_counts(file: Path) -> tuple[int, int] | None:
    """Numbers of vertices and faces that a file announces; None where that cannot be told at a glance."""
    try:
        with file.open("rb") as lines:
            suffix = file.suffix.lower()
            if suffix == ".obj":
                starts = [line[:2] for line in lines]
                return sum(s in (b"v ", b"v\t") for s in starts), sum(s in (b"f ", b"f\t") for s in starts)
            head = b"".join(islice(lines, HEADER_LINES))
    except OSError:
        return None
    if suffix == ".ply":
        found = [re.search(rb"element %s (\d+)" % name, head) for name in (b"vertex", b"face")]
        numbers = [int(each[1]) for each in found if each]
    else:
        words = [word for line in head.splitlines() for word in line.partition(b"#")[0].split()]
        numbers = [int(word) for word in words[:4] if word.isdigit()]
    return (numbers[0], numbers[1]) if len(numbers) >= 2 else None
