"""Whether a report is what would be drawn again: then a repeated run need not draw it."""

import hashlib
import json
from functools import cache
from importlib.metadata import version
from pathlib import Path

from evaluation.store import ResultsStore, write_json

PAIRS = 24
"""Pairs drawn by default; a sweep may have thousands."""
RECORD = "made.json"
LIBRARIES = ("matplotlib", "pandas", "jinja2", "mitsuba")


def note_made(store: ResultsStore, folder: Path, pairs: int | None) -> None:
    """Write down what a report was made of, and its files."""
    files = sorted(str(p.relative_to(folder)) for p in folder.rglob("*") if p.is_file() and p.name != RECORD)
    write_json(folder / RECORD, {"state": _state(store, pairs), "files": files})


def is_made(store: ResultsStore, folder: Path, pairs: int | None) -> bool:
    """Whether the report in a folder was made of these results by this code, and is complete."""
    try:
        record = json.loads((folder / RECORD).read_text(encoding="utf-8"))
        return record["state"] == _state(store, pairs) and all(
            (folder / f).is_file() for f in record["files"]
        )
    except (OSError, ValueError, KeyError, TypeError):
        return False


def _state(store: ResultsStore, pairs: int | None) -> str:
    """Hash of the results, of the code that draws, and of how many pairs are drawn."""
    total = hashlib.sha256(f"{_code()} {pairs}".encode())
    for name in ("run.json", "table.parquet"):
        file = store.folder / name
        total.update(name.encode() + (file.read_bytes() if file.is_file() else b""))
    return total.hexdigest()


@cache
def _code() -> str:
    root = Path(__file__).parents[1]
    total = hashlib.sha256(" ".join(f"{name} {version(name)}" for name in LIBRARIES).encode())
    for package in ("reports", "evaluation"):
        for file in sorted((root / package).rglob("*")):
            if file.is_file() and file.suffix != ".pyc":
                total.update(file.name.encode() + b"\0" + file.read_bytes() + b"\0")
    return total.hexdigest()
