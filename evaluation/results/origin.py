"""Where a table comes from, in every file of it: the version of the program, the experiment, its settings.

CSV has it as columns at the end, since readers of plain CSV know no comments; Parquet as metadata (pandas:
``read_parquet(file).attrs``); Markdown and LaTeX as a line.
"""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from datasets_gen.collections.folder import code_version
from datasets_gen.fingerprints import digest
from datasets_gen.records import atomic_path

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True)
class Origin:
    """What made a table; empty where earlier versions did not note it.

    Attributes
    ----------
    medialbench_version : str
        Of a merged folder, the versions of all runs.
    experiment : str
    config_hash : str
        16 hexadecimal digits of the hash of all settings.
    """

    medialbench_version: str = ""
    experiment: str = ""
    config_hash: str = ""

    @classmethod
    def of(cls, name: str, settings: Mapping[str, Any]) -> "Origin":
        """Of what this version makes of an experiment."""
        return cls(code_version(), name, digest(settings)[:16])

    @classmethod
    def of_run(cls, info: Mapping[str, Any]) -> "Origin":
        """Of a results folder, by what its ``run.json`` holds."""
        runs = info.get("merged_from", [info])
        versions = {str(each.get("versions", {}).get("medialbench", "")) for each in runs} - {""}
        experiment, settings = (str(info.get(key, "")) for key in ("experiment", "config_hash"))
        return cls(", ".join(sorted(versions)), experiment, settings)

    @property
    def line(self) -> str:
        """In words: ``medialbench 0.1.0, experiment quick, settings 0123456789abcdef``; empty if unknown."""
        words = ("medialbench", "experiment", "settings")
        known = zip(words, asdict(self).values(), strict=True)
        return ", ".join(f"{word} {value}" for word, value in known if value)

    def marked(self, table: "pd.DataFrame") -> "pd.DataFrame":
        """The table with what is known of its origin as columns at the end."""
        return table.assign(**{name: value for name, value in asdict(self).items() if value})


def write_csv(table: "pd.DataFrame", path: Path, origin: Origin) -> None:
    """Write a table as CSV, with its origin as columns at the end."""
    with atomic_path(path) as temporary:
        origin.marked(table).to_csv(temporary, index=False)


def write_parquet(table: "pd.DataFrame", path: Path, origin: Origin) -> None:
    """Write a table as Parquet, with its origin as metadata."""
    noted = table.copy(deep=False)
    noted.attrs = asdict(origin)
    with atomic_path(path) as temporary:
        noted.to_parquet(temporary)
