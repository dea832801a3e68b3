"""Methods that run elsewhere: a folder of correspondence files, scored like any other.

Learned methods (DPFM, DV-Matcher, Lepard, ...) need not be installed here. `export` writes the clouds of a
results folder and the list of pairs; run the method on them wherever it lives; put its files into a folder.
"""

import csv
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.fingerprints import digest_files
from datasets_gen.records import InputError, atomic_path
from evaluation.experiment.toml_tables import expect
from evaluation.methods.base import Method, MethodInput, dense
from evaluation.results.outcome import one_line
from evaluation.results.store import ResultsStore
from medial import Matching

SUFFIXES = (".npz", ".npy", ".txt", ".csv")


@dataclass(frozen=True, kw_only=True)
class External(Method):
    """Reads ``<source>--<target>`` with one of `SUFFIXES`, where the names are the keys of the scans.

    ``.npz`` holds ``source_to_target`` and optionally ``confidence``; ``.npy`` the ids; ``.txt`` and
    ``.csv`` one id per line, optionally followed by a confidence. Ids count from 0; -1 is no match.
    """

    folder: str = ""
    first_id: int = 0
    """Id of the first target point: 1 for files that count from 1."""

    def __post_init__(self) -> None:
        """Check the folder."""
        expect(
            Path(self.folder).is_dir() and self.folder != "", f"no folder {self.folder!r} of correspondences"
        )

    def fingerprint(self) -> str:
        """Hash of all correspondence files."""
        return digest_files(*(path for path in Path(self.folder).iterdir() if path.suffix in SUFFIXES))

    def match(self, source: MethodInput, target: MethodInput, seed: int) -> Matching:
        """Read the file of the pair."""
        stem = Path(self.folder) / f"{source.name}--{target.name}"
        found = [path for suffix in SUFFIXES if (path := stem.with_name(stem.name + suffix)).is_file()]
        if not found:
            raise InputError(f"no correspondence file {str(stem)!r} with {', '.join(SUFFIXES)}")
        ids, confidence = read_correspondence(found[0])
        if len(ids) != len(source):
            raise InputError(f"{str(found[0])!r} holds {len(ids)} ids for a source of {len(source)} points")
        image = np.where(ids < self.first_id, -1, ids - self.first_id)
        return dense(image, confidence, seed=seed)


def read_correspondence(path: Path) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Target ids and confidences of a file; confidence is 1 where the file has none.

    Raises
    ------
    InputError
        If the file cannot be read or holds no ids.
    """
    try:
        confidence: Any = None
        if path.suffix == ".npz":
            with np.load(path, allow_pickle=False) as data:
                ids = data["source_to_target"]
                confidence = data.get("confidence")
        elif path.suffix == ".npy":
            ids = np.load(path, allow_pickle=False)
        else:
            delimiter = "," if path.suffix == ".csv" else None
            table = np.loadtxt(path, ndmin=2, delimiter=delimiter)
            ids, confidence = table[:, 0], table[:, 1] if table.shape[1] > 1 else None
        ids = np.asarray(ids).ravel()
        whole = ids.astype(np.int64)
        if not (whole == ids).all():
            raise ValueError("ids are no whole numbers")
        sure = None if confidence is None else np.asarray(confidence, np.float64).ravel()
        if sure is not None and len(sure) != len(whole):
            raise ValueError(f"{len(whole)} ids with {len(sure)} confidences")
    except Exception as error:  # NumPy's readers raise anything on a broken file
        raise InputError(f"{str(path)!r} is not a readable correspondence ({one_line(error)})") from error
    return whole, np.where(whole >= 0, 1.0, 0.0) if sure is None else sure


def export(store: ResultsStore, folder: str | os.PathLike[str]) -> Path:
    """Write the clouds and pairs of a results folder for a method that runs elsewhere.

    Parameters
    ----------
    store
        A finished run with a matching part.
    folder
        Gets ``clouds/<key>.xyz`` (x y z nx ny nz per line) and ``pairs.csv`` (source, target, regime).

    Returns
    -------
    Path
        Of ``pairs.csv``.
    """
    root = Path(folder)
    maps = store.table().query("kind == 'matching'")
    pairs = maps[["source_scan", "target_scan", "regime"]].drop_duplicates()
    for key in sorted({*pairs.source_scan, *pairs.target_scan}):
        scan = store.scan(key)
        with atomic_path(root / "clouds" / f"{key}.xyz") as temporary:
            np.savetxt(temporary, np.hstack([scan.points, scan.normals]), fmt="%.9g")
    with (
        atomic_path(root / "pairs.csv") as temporary,
        temporary.open("w", newline="", encoding="utf-8") as stream,
    ):
        writer = csv.writer(stream)
        writer.writerow(["source", "target", "regime"])
        writer.writerows(pairs.itertuples(index=False))
    return root / "pairs.csv"
