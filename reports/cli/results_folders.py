"""Opening a results folder; a folder of results folders is answered with the list of those in it."""

from pathlib import Path
from typing import TYPE_CHECKING

from reports.cli.console import Failure

if TYPE_CHECKING:
    from evaluation import ResultsStore


def open_results(folder: Path, command: str) -> "ResultsStore":
    """The results in a folder.

    Parameters
    ----------
    folder
    command
        Of the command line, for the hint.

    Raises
    ------
    Failure
        If the folder holds no results but folders that do.
    InputError
        If they are of another format, or the note of their run is damaged.
    """
    from evaluation.results.store import ResultsStore

    if folder.is_dir() and not _has_results(folder):
        inside = sorted(each for each in folder.iterdir() if each.is_dir() and _has_results(each))
        if inside:
            names = ", ".join(each.name for each in inside)
            raise Failure(
                f"{str(folder)!r} holds results folders: {names}; give one: medialbench {command} {inside[0]}"
            )
    store = ResultsStore(folder)
    store.run_info()  # refuses a damaged one
    return store


def _has_results(folder: Path) -> bool:
    return (folder / "run.json").is_file() or (folder / "table.parquet").is_file()
