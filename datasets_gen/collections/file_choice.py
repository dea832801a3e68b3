"""Which files of a data set are wanted: names in natural order, one subject of several, chosen poses."""

import re
from collections.abc import Collection as Names
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import TypeVar

from datasets_gen.records import InputError

T = TypeVar("T")


def files_of(folder: Path, suffixes: Iterable[str]) -> dict[str, Path]:
    """Files of a folder with certain endings, by their stem in natural order.

    Raises
    ------
    InputError
        If two have the same stem.
    """
    wanted = tuple(suffixes)
    found = [file for file in folder.iterdir() if file.suffix.lower() in wanted and file.is_file()]
    found.sort(key=lambda file: natural(file.name))
    files: dict[str, Path] = {}
    for file in found:
        if file.stem in files:
            raise InputError(
                f"{str(folder)!r} has {files[file.stem].name!r} and {file.name!r} for one shape; keep one"
            )
        files[file.stem] = file
    return files


def class_of(stem: str) -> str:
    """Name of the subject in a name with a number: ``cat`` of ``cat10``, ``tr_reg`` of ``tr_reg_005``."""
    return re.sub(r"[\s_-]*\d+$", "", stem)


def one_subject(found: Mapping[str, T], asked: str | None, folder: Path) -> tuple[str, T]:
    """The subject that is asked for, or the only one.

    Raises
    ------
    InputError
        If it is not there, or none is asked for and there are several.
    """
    if asked is not None:
        if asked not in found:
            raise InputError(f"{str(folder)!r} has no subject {asked!r}; it has {', '.join(found)}")
        return asked, found[asked]
    if len(found) > 1:
        raise InputError(
            f"{str(folder)!r} holds several subjects: {', '.join(found)}; choose one with the option subject"
        )
    return next(iter(found.items()))


def chosen(
    known: Sequence[str], subject: str, poses: Sequence[str] | None, reference: str | None
) -> tuple[list[str], str]:
    """The poses to load and the reference: those that are asked for, or all and the first.

    Raises
    ------
    InputError
        If one is not there.
    """
    if reference is not None and reference not in known:
        raise InputError(f"{subject!r} has no pose {reference!r} to be the reference; it has {list(known)}")
    wanted = list(known) if poses is None else pose_list(poses, known, subject)
    return wanted, known[0] if reference is None else reference


def pose_list(poses: Sequence[str], known: Names[str], subject: str) -> list[str]:
    """The poses asked for, once each, in the order asked.

    Raises
    ------
    InputError
        If it is not a list of poses that there are.
    """
    if isinstance(poses, str) or not isinstance(poses, Names) or not len(poses):
        raise InputError(f"poses of {subject!r} is {poses!r}; give a list of {list(known)}")
    for pose in poses:
        if pose not in list(known):
            raise InputError(f"{subject!r} has no pose {pose!r}; it has {list(known)}")
    return list(dict.fromkeys(poses))


def natural(name: str) -> list[tuple[int, int, str]]:
    """Sort key that puts pose2 before pose10."""
    parts = re.split(r"(\d+)", name.lower())
    return [(0, int(part), "") if part.isdigit() else (1, 0, part) for part in parts if part]
