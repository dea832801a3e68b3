"""Checks of output paths before any work is done, and the names that outputs have by default."""

import os
from collections.abc import Iterable
from pathlib import Path

from datasets_gen.records import InputError


def check_output_file(
    path: str | os.PathLike[str],
    suffixes: tuple[str, ...],
    inputs: Iterable[str | os.PathLike[str]] = (),
) -> Path:
    """The path, if a file of one of these types can be written there.

    Parameters
    ----------
    path
    suffixes
        Accepted endings, such as ``".npz"``.
    inputs
        Files that are read, which must not be overwritten.

    Raises
    ------
    InputError
        If the suffix is another one, the path is a folder or an input, or the folder cannot be written.
    """
    file = Path(path)
    if file.suffix.lower() not in suffixes:
        raise InputError(f"cannot write {str(path)!r}; choose a name that ends in {' or '.join(suffixes)}")
    if file.is_dir():
        raise InputError(f"cannot write {str(path)!r}: it is a folder; choose a file name")
    _check_not_input(file, inputs)
    check_output_folder(file.parent)
    return file


def check_output_folder(
    folder: str | os.PathLike[str], inputs: Iterable[str | os.PathLike[str]] = ()
) -> Path:
    """The folder, if it can be written or created.

    Parameters
    ----------
    folder
    inputs
        Folders that are read, whose files must not be overwritten.

    Raises
    ------
    InputError
        If it is an input, or it, or the nearest folder above it that exists, is no folder or not writable.
    """
    _check_not_input(Path(folder), inputs)
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


def _check_not_input(output: Path, inputs: Iterable[str | os.PathLike[str]]) -> None:
    """Raise InputError if the output is one of the inputs, also by a link or in another case."""
    for each in inputs:
        if output.exists() and Path(each).exists() and output.samefile(each):
            raise InputError(
                f"{str(output)!r} is the input {str(each)!r} and would be overwritten; choose another -o"
            )


def default_output(inputs: Iterable[Path], kind: str) -> Path:
    """An output in the current folder, such as ``a-b.map.npz`` for ``a.scan.npz`` and ``b.ply``."""
    stems = (path.stem.removesuffix(".scan") for path in inputs)
    return Path(f"{'-'.join(stems)}.{kind}.npz")
