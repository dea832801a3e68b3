"""Data sets whose files have the same faces in the same order: SCAPE and the registrations of FAUST."""

import os
import re
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from datasets_gen.collection import Collection
from datasets_gen.collections.file_choice import chosen, files_of
from datasets_gen.collections.folder import check_shared
from datasets_gen.collections.sound_poses import sound_poses
from datasets_gen.meshes.files import MESH_SUFFIXES, read_mesh
from datasets_gen.meshes.mirroring import mirror_map
from datasets_gen.records import InputError

SCAPE = r"mesh\d{3}"
SCAPE_SPLITS = {"train": range(51), "test": range(52, 72)}
FAUST = r"tr_reg_\d{3}"
FAUST_SPLITS = {"train": range(80), "test": range(80, 100)}
REGISTRATIONS = ("training/registrations", "registrations", ".")
SCANS = ("training/scans", "scans", ".")
PEOPLE = range(10)


def recognises_scape(folder: Path) -> bool:
    """Whether every mesh is called like ``mesh000``."""
    return _all_called(folder, SCAPE)


def recognises_faust(folder: Path) -> bool:
    """Whether there are registrations or scans of FAUST."""
    return any(_all_called(folder / each, FAUST) for each in REGISTRATIONS) or any(
        _all_called(folder / each, r"(tr|test)_scan_\d{3}") for each in SCANS
    )


def outline_scape(
    folder: str | os.PathLike[str],
    *,
    split: str | None = None,
    poses: Sequence[str] | None = None,
    reference: str | None = None,
    fill: bool = True,
) -> dict[str, Any]:
    """Subject, poses and reference that `load_scape` would give, from the names of the files.

    Parameters
    ----------
    folder, split, poses, reference, fill
        As for `load_scape`.
    """
    return _outline("scape", _scape_files(folder), SCAPE_SPLITS, PEOPLE, split, poses, reference)


def load_scape(
    folder: str | os.PathLike[str],
    *,
    split: str | None = None,
    poses: Sequence[str] | None = None,
    reference: str | None = None,
    fill: bool = True,
) -> Collection:
    """Load SCAPE: poses of one person, ``mesh000`` to ``mesh071`` without ``mesh051``.

    Parameters
    ----------
    folder
    split
        ``"train"`` (0 to 50) or ``"test"`` (52 to 71). Default: all.
    poses, reference
        Names such as ``"mesh010"``. Default: all of the split, and the first file whatever the split.
    fill
        Whether small holes are filled.

    Raises
    ------
    InputError
        If a file cannot be used, or the files differ in their faces.
    """
    told = outline_scape(folder, split=split, poses=poses, reference=reference)
    return _load(_scape_files(folder), told, fill)


def outline_faust(
    folder: str | os.PathLike[str],
    *,
    split: str | None = None,
    people: Sequence[int] | None = None,
    poses: Sequence[str] | None = None,
    reference: str | None = None,
    fill: bool = True,
) -> dict[str, Any]:
    """Subject, poses and reference that `load_faust` would give, from the names of the files.

    Parameters
    ----------
    folder, split, people, poses, reference, fill
        As for `load_faust`.
    """
    numbers = isinstance(people, Sequence) and all(isinstance(p, int) and p in PEOPLE for p in people)
    if people is not None and not (people and numbers):
        raise InputError(f"people is {people!r}; give a list of numbers from 0 to 9")
    return _outline("faust", _faust_files(folder), FAUST_SPLITS, people or PEOPLE, split, poses, reference)


def load_faust(
    folder: str | os.PathLike[str],
    *,
    split: str | None = None,
    people: Sequence[int] | None = None,
    poses: Sequence[str] | None = None,
    reference: str | None = None,
    fill: bool = True,
) -> Collection:
    """Load the registrations of FAUST: ten poses of each of ten people, all of one topology.

    Scans have no exact ground truth and are not loaded.

    Parameters
    ----------
    folder
        With ``training/registrations``, or one of these two.
    split
        ``"train"`` (0 to 79) or ``"test"`` (80 to 99). Default: all.
    people
        Numbers from 0 to 9; person k has the files 10 k to 10 k + 9. Default: all.
    poses, reference
        Names such as ``"tr_reg_010"``. Default: all of these, and the first file whatever the split.
    fill
        Whether small holes are filled.

    Raises
    ------
    InputError
        If a file cannot be used, or the files differ in their faces.
    """
    told = outline_faust(folder, split=split, people=people, poses=poses, reference=reference)
    return _load(_faust_files(folder), told, fill)


def _all_called(folder: Path, pattern: str) -> bool:
    """Whether there are meshes, and each is called so."""
    if not folder.is_dir():
        return False
    stems = [file.stem for file in folder.iterdir() if file.suffix.lower() in MESH_SUFFIXES]
    return bool(stems) and all(re.fullmatch(pattern, stem) for stem in stems)


def _scape_files(folder: str | os.PathLike[str]) -> dict[str, Path]:
    return files_of(Path(folder), MESH_SUFFIXES)


def _faust_files(folder: str | os.PathLike[str]) -> dict[str, Path]:
    root = next(
        (Path(folder, each) for each in REGISTRATIONS if _all_called(Path(folder, each), FAUST)), None
    )
    if root is None:
        raise InputError(
            f"{str(folder)!r} holds scans of FAUST, which have no exact ground truth; add "
            "training/registrations, or use `medialbench match` and `medialbench inspect` on the scans"
        )
    return files_of(root, MESH_SUFFIXES)


def _outline(
    subject: str,
    files: dict[str, Path],
    splits: dict[str, range],
    people: Sequence[int],
    split: str | None,
    poses: Sequence[str] | None,
    reference: str | None,
) -> dict[str, Any]:
    """What is loaded of so many files."""
    if split not in (None, *splits):
        raise InputError(f"split is {split!r}; choose {' or '.join(splits)}, or leave it out for all")
    numbers = {stem: int(stem[-3:]) for stem in files}
    inside = [
        stem
        for stem, number in numbers.items()
        if (split is None or number in splits[split]) and (people is PEOPLE or number // 10 in people)
    ]
    if not inside:
        raise InputError(f"{subject!r} has no files of what is asked for; it has {', '.join(files)}")
    wanted, _ = chosen(inside, subject, poses, None)
    return {
        "subject": subject,
        "poses": wanted,
        "reference": chosen(list(files), subject, None, reference)[1],
    }


def _load(files: dict[str, Path], told: dict[str, Any], fill: bool) -> Collection:
    """The poses of an outline."""
    subject, rest = told["subject"], told["reference"]
    order = list(dict.fromkeys([rest, *told["poses"]]))
    shapes = [replace(read_mesh(files[pose], subject), name=f"{subject}/{pose}", pose=pose) for pose in order]
    check_shared(shapes, files)
    sound, _, remarks = sound_poses(shapes, fill=fill)
    found = dict(zip(order, sound, strict=True))
    wanted = tuple(found[pose] for pose in told["poses"])
    return Collection(subject, wanted, found[rest], mirror_map(found[rest]), remarks=tuple(remarks))
