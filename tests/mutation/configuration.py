"""What is mutated and how, from ``modules.toml``."""

import tomllib
from pathlib import Path

FILE = Path(__file__).with_name("modules.toml")
_TABLE = tomllib.loads(FILE.read_text(encoding="utf-8"))["cosmic-ray"]
MODULES = _TABLE["modules"]
"""Arguments of pytest for each module, by its path."""
MOST = _TABLE["most"]
"""Mutants of a module; of more, a random sample is run."""


def database(folder, module):
    """File of a module's session."""
    return folder / (module.removesuffix(".py").replace("/", "-") + ".sqlite")
