"""Formats that need packages which are not installed with the others."""

import os
from importlib.util import find_spec
from pathlib import Path

from datasets_gen.extras import pip_install
from datasets_gen.records import InputError

NEEDS = {".las": ("laspy",), ".laz": ("laspy", "lazrs"), ".e57": ("pye57",)}
"""Packages by suffix: the extra ``exports``."""


def check_packages(path: str | os.PathLike[str]) -> None:
    """Raise InputError if a package is missing that a file of this suffix needs."""
    missing = [name for name in NEEDS.get(Path(path).suffix.lower(), ()) if find_spec(name) is None]
    if missing:
        raise InputError(
            f"cannot write {str(path)!r}: the package {missing[0]} is missing; {pip_install('exports')}, "
            "or write .npz or .ply"
        )
