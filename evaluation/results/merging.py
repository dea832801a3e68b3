"""Results of several machines in one folder."""

import logging
import os
import shutil
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from datasets_gen.records import InputError, atomic_path
from evaluation.experiment.experiment import Experiment, portable
from evaluation.results.folder_lock import lock_folder
from evaluation.results.origin import Origin, write_csv, write_parquet
from evaluation.results.result_files import FOLDERS
from evaluation.results.store import FORMAT, ResultsStore
from evaluation.results.table import COLUMNS

if TYPE_CHECKING:
    import pandas as pd

log = logging.getLogger(__name__)

IDENTITY = ["kind", "dataset", "subject", "method", "regime", "source_pose", "target_pose", "views", "seed"]
"""Columns that say what a row is about; two rows that agree in them must be the same result."""

MAY_DIFFER = ("name", "description", "dataset", "method", "seeds", "timeout")
"""Parts of experiments that may differ between folders: how work is split over machines."""


def merge_results(folders: Sequence[str | os.PathLike[str]], out: str | os.PathLike[str]) -> ResultsStore:
    """Join results folders that share the work of one experiment by data set, method or seed.

    The folder stands by itself: results are linked where the file system can, else copied. The joint
    experiment is written too, so that `evaluation.run` goes on with what is missing.

    Parameters
    ----------
    folders
        Finished or interrupted runs.
    out
        A folder that is empty or does not exist.

    Returns
    -------
    ResultsStore

    Raises
    ------
    InputError
        If a folder holds no results, their experiments differ in more than data sets, methods and seeds, they
        hold different results for the same row, or `out` holds something.
    """
    stores = [ResultsStore(folder) for folder in folders]
    if not stores:
        raise InputError("nothing to merge; name at least one results folder")
    experiment = _joint([(store.folder, Experiment.from_table(store.settings)) for store in stores])
    table = _joint_table(stores)
    target = Path(out).resolve()
    if target.is_dir() and any(not each.name.startswith(".lock") for each in target.iterdir()):
        raise InputError(f"{str(out)!r} holds files already; merge into a new folder")
    with lock_folder(target):
        for store in stores:
            _link(store, target)
        with atomic_path(target / "experiment.toml") as temporary:
            temporary.write_text(experiment.to_toml(), encoding="utf-8")
        info = _joint_info(stores, experiment, len(table))
        _write_tables(stores, table, target, Origin.of_run(info))
        ResultsStore(target).write_run_info(info)
    return ResultsStore(target)


def _joint(experiments: list[tuple[Path, Experiment]]) -> Experiment:
    """The experiment that covers all: the union of data sets, methods and seeds."""
    home, first = experiments[0]
    parts: dict[str, list[Any]] = {key: list(getattr(first, key)) for key in ("dataset", "method", "seeds")}
    for folder, other in experiments[1:]:
        mine, theirs = first.as_dict(), other.as_dict()
        for key in mine:
            if key not in MAY_DIFFER and mine[key] != theirs[key]:
                raise InputError(
                    f"{str(home)!r} and {str(folder)!r} differ in {key!r}; "
                    "only data sets, methods and seeds may"
                )
        for key, found in parts.items():
            found.extend(each for each in getattr(other, key) if each not in found)
    changes: dict[str, Any] = {key: tuple(found) for key, found in parts.items()}
    return replace(first, **changes)


def _joint_table(stores: list[ResultsStore]) -> "pd.DataFrame":
    import pandas as pd

    tables = [store.table() for store in stores]
    joint = pd.concat(tables, ignore_index=True).drop_duplicates("score_key", ignore_index=True)
    keys = joint[IDENTITY].astype("string").fillna("")
    twice = keys.duplicated(keep=False) & ~joint.duplicated([*IDENTITY, "score_key"], keep=False)
    if twice.any():
        row = joint[twice].iloc[0]
        what = f"{row.dataset}, {row.method}, {row.source_pose} to {row.target_pose}, seed {row.seed}"
        raise InputError(f"the folders hold different results for {what}; they were made by different code")
    return joint.reindex(columns=list(COLUMNS)).astype(COLUMNS)  # earlier versions had fewer columns


def _link(store: ResultsStore, target: Path) -> None:
    """Bring every result of a folder that is whole into another that lacks it."""
    for stage, name in FOLDERS.items():
        for note in sorted((store.folder / name).glob("[!.]*.json")):
            if (target / name / note.name).exists():
                continue
            try:
                path = store.whole_path(stage, note.stem)
            except InputError as error:
                log.warning("left out: %s", error)
                continue
            for each in dict.fromkeys((path, note)):  # the record last: it says that the result is there
                _link_file(each, target / name / each.name)


def _link_file(path: Path, goal: Path) -> None:
    with atomic_path(goal) as temporary:
        temporary.unlink()
        try:
            os.link(path, temporary)
        except OSError:
            shutil.copyfile(path, temporary)


def _write_tables(stores: list[ResultsStore], table: "pd.DataFrame", target: Path, origin: Origin) -> None:
    """The joint table, and the failures that no folder made good."""
    import pandas as pd

    failures = pd.concat([store.failures() for store in stores], ignore_index=True).drop_duplicates("key")
    made = {path.stem for name in FOLDERS.values() for path in (target / name).glob("*.json")}
    write_csv(failures[~failures["key"].isin(made)], target / "failures.csv", origin)
    write_parquet(table, target / "table.parquet", origin)
    write_csv(table, target / "table.csv", origin)


def _joint_info(stores: list[ResultsStore], experiment: Experiment, rows: int) -> dict[str, Any]:
    infos = [store.run_info() for store in stores]
    datasets: dict[str, str] = {}
    for info in infos:
        datasets |= info.get("datasets", {})
    return {
        "format": FORMAT,
        "experiment": experiment.name,
        "config_hash": Origin.of(experiment.name, portable(experiment.as_dict())).config_hash,
        "seeds": list(experiment.seeds),
        "datasets": datasets,
        "rows": rows,
        "merged_from": [{"folder": str(s.folder), **i} for s, i in zip(stores, infos, strict=True)],
    }
