"""Checks of output paths before any work is done."""

import os
from pathlib import Path

from datasets_gen.records import InputError


def check_output_file(path: str | os.PathLike[str], suffixes: tuple[str, ...]) -> Path:
    """The path, if a file of one of these types can be written there.

    Raises
    ------
    InputError
        If the suffix is another one, the path is a folder, or the folder cannot be written.
    """
    file = Path(path)
    if file.suffix.lower() not in suffixes:
        raise InputError(f"cannot write {str(path)!r}; choose a name that ends in {' or '.join(suffixes)}")
    if file.is_dir():
        raise InputError(f"cannot write {str(path)!r}: it is a folder; choose a file name")
    check_output_folder(file.parent)
    return file


def check_output_folder(folder: str | os.PathLike[str]) -> Path:
    """The folder, if it can be written or created.

    Raises
    ------
    InputError
        If it, or the nearest folder above it that exists, is no folder or not writable.
    """
    existing = Path(folder).absolute()
    while not existing.exists() and existing != existing.parent:
        existing = existing.parent
    if not existing.is_dir():
        raise InputError(
            f"cannot write to {str(folder)!r}: {str(existing)!r} is not a folder; choose another"
        )
    if not os.access(existing, os.W_OK | os.X_OK):
        raise InputError(f"cannot write to {str(folder)!r}: no permission; choose a folder you can write to")
    return Path(folder)
