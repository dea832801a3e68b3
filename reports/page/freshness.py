"""Whether a report is what would be drawn again: then a repeated run need not draw it."""

from pathlib import Path

from datasets_gen.fingerprints import code_fingerprint, digest, digest_files
from datasets_gen.parsing import read_note
from evaluation.results.store import ResultsStore, write_json

PAIRS = 24
"""Pairs drawn by default; a sweep may have thousands."""
RECORD = "made.json"
TEMPLATES = ("page/*.j2", "page/*.css", "page/*.js", "viewer/*.css", "viewer/*.js")
"""Files of this package that a report is made of besides code."""


def note_made(store: ResultsStore, folder: Path, pairs: int | None) -> None:
    """Write down what a report was made of, and its files."""
    files = sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file() and p.name != RECORD)
    write_json(folder / RECORD, {"state": _state(store, pairs), "files": files})


def is_made(store: ResultsStore, folder: Path, pairs: int | None) -> bool:
    """Whether the report in a folder was made of these results by this code, and is complete."""
    record = read_note(folder / RECORD, state=str, files=list)
    if record is None or record["state"] != _state(store, pairs):
        return False
    return all(isinstance(file, str) and (folder / file).is_file() for file in record["files"])


def _state(store: ResultsStore, pairs: int | None) -> str:
    """Hash of the results, of the code and templates that draw, and of how many pairs are drawn."""
    results = (store.folder / name for name in ("run.json", "table.parquet"))
    templates = (file for pattern in TEMPLATES for file in Path(__file__).parents[1].glob(pattern))
    files = digest_files(*templates), digest_files(*(file for file in results if file.is_file()))
    return digest([code_fingerprint("reports.page.report"), files, pairs])
