"""Methods that run elsewhere: a folder of correspondence files, scored like any other.

Learned methods (DPFM, DV-Matcher, Lepard, ...) need not be installed here. `export` writes the clouds of a
results folder and the list of pairs; run the method on them wherever it lives; put its files into a folder.
"""

import csv
import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from datasets_gen.correspondences.point_map import FORMATS, ON_TRIANGLES
from datasets_gen.correspondences.reading import read_map
from datasets_gen.fingerprints import digest_files
from datasets_gen.records import InputError, atomic_path
from evaluation.experiment.toml_tables import expect
from evaluation.methods.base import Method, MethodInput, dense
from evaluation.results.store import ResultsStore
from medial import Matching

SUFFIXES = tuple(suffix for suffix in FORMATS if suffix not in ON_TRIANGLES)


@dataclass(frozen=True, kw_only=True)
class External(Method):
    """Reads ``<source>--<target>`` with one of `SUFFIXES`, where the names are the keys of the scans.

    The formats are those of `datasets_gen.correspondences`. Ids count from 0, from 1 in ``.vts`` and
    ``.mat``, or as the header of a file says; -1 is no match. Confidence is 1 where a file has none.
    """

    folder: str = ""
    first_id: int | None = None
    """Id of the first target point, 0 or 1, whatever format and header say."""

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
        read = read_map(found[0], self.first_id, otherwise=0)
        if len(read) != len(source):
            raise InputError(f"{str(found[0])!r} holds {len(read)} ids for a source of {len(source)} points")
        read.check_target(len(target), 0, repr(str(found[0])))
        sure = np.where(read.matched, 1.0, 0.0) if read.confidence is None else read.confidence
        return dense(read.ids, sure, seed=seed)


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
