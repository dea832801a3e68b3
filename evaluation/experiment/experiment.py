"""An experiment: which shapes, scanned how, matched by what. Read from TOML; frozen; complete.

Sections of the file (every key is a field below, with its default):

``[[dataset]]`` (`DatasetSection`), ``[scan]`` (`ScanCondition`: the base from which sweeps deviate),
``[operators]`` (`OperatorsSection`), ``[stability]`` (`StabilitySection`, Eq. 18), ``[matching]``
(`MatchingSection`), ``[[method]]`` (`MethodSection`), and ``name``, ``description``, ``seeds``, ``timeout``,
``evaluated``, ``departures`` at the top.
"""

import copy
import itertools
import os
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass, field, fields
from pathlib import Path
from typing import Any

from datasets_gen.collections.layouts import is_data
from datasets_gen.paths import check_text
from datasets_gen.registry import names
from datasets_gen.values import check_count, check_seed
from evaluation.experiment.config_sections import (
    DatasetSection,
    MatchingSection,
    MethodSection,
    OperatorsSection,
    Regime,
    ScanCondition,
    StabilitySection,
)
from evaluation.experiment.presets import preset_or_file, presets
from evaluation.experiment.toml_tables import (
    dataclass_from_table,
    expect,
    expect_distinct,
    reject_unknown,
    to_toml,
)
from medial.departures import Departures

LONGEST = 1e7
"""Largest time-out of a task, seconds: four months."""


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """Everything that decides the results of a run."""

    name: str
    description: str = ""
    dataset: tuple[DatasetSection, ...]
    scan: ScanCondition = field(default_factory=ScanCondition)
    operators: OperatorsSection = field(default_factory=OperatorsSection)
    stability: StabilitySection | None = None
    matching: MatchingSection | None = None
    method: tuple[MethodSection, ...] = ()
    seeds: tuple[int, ...] = (0,)
    timeout: float = 1800.0
    """Seconds after which a task is stopped and recorded as a failure."""
    evaluated: int = 2000
    """Points of each map, drawn once per pair, at which geodesic errors are measured."""
    departures: Mapping[str, bool] | str = "all"
    """From the paper: ``"all"``, ``"none"`` or truth values by name; of operators, maps and Eq. 18 alike."""

    def __post_init__(self) -> None:
        """Check what concerns several sections."""
        expect(len(self.dataset) > 0, "no [[dataset]]: nothing to scan")
        Departures.of(self.departures)
        expect(0 < self.timeout <= LONGEST, f"timeout is {self.timeout!r}; give up to {LONGEST:.0e} seconds")
        check_count(self.evaluated, "evaluated")
        for seed in self.seeds:
            check_seed(seed, "each of seeds")
        expect_distinct(self.seeds, "seeds")
        expect(
            self.stability is not None or self.matching is not None,
            "neither [stability] nor [matching]: nothing to measure",
        )
        expect(
            self.matching is None or len(self.method) > 0,
            "[matching] without a [[method]]: nothing to match with",
        )
        labels = [method.label for method in self.method]
        for label in labels:
            expect(bool(label.strip()), "a method's label is empty; give one")
            check_text(label, "label")
            expect(labels.count(label) == 1, f"two methods are called {label!r}; give each its own label")
        self.stability_conditions()
        self.regimes()

    def stability_conditions(self) -> tuple[tuple[str, ScanCondition], ...]:
        """Names and scan conditions of the Eq. 18 part."""
        if self.stability is None:
            return ()
        return tuple(
            (_named(values), self.scan.with_values(values)) for values in _product(self.stability.sweep)
        )

    def regimes(self) -> tuple[Regime, ...]:
        """Regimes of the matching part."""
        if self.matching is None:
            return ()
        swept = _product(self.matching.sweep) if self.matching.sweep or not self.matching.regime else []
        named = [(values, _named(values)) for values in swept]
        named += [
            ({k: v for k, v in each.items() if k != "name"}, each["name"]) for each in self.matching.regime
        ]
        return tuple(_regime(self.scan, values, name) for values, name in named)

    def as_dict(self) -> dict[str, Any]:
        """Every setting, as tables that `from_table` reads back."""
        return asdict(self)

    def to_toml(self) -> str:
        """Every setting as the text of a TOML file that `load` reads back."""
        return to_toml(self.as_dict())

    @classmethod
    def from_table(cls, table: Mapping[str, Any], where: str = "experiment") -> "Experiment":
        """Build from parsed TOML.

        Raises
        ------
        InputError
            If a key is unknown (the nearest valid one is named) or a value cannot be used.
        """
        values = dict(table)
        reject_unknown(values, [f.name for f in fields(cls)], where)
        values["dataset"] = tuple(
            dataclass_from_table(DatasetSection, each, f"{where}: [[dataset]]")
            for each in _list(values, "dataset", where)
        )
        values["method"] = tuple(
            _method(each, f"{where}: [[method]]") for each in _list(values, "method", where)
        )
        sections = (
            ("scan", ScanCondition),
            ("operators", OperatorsSection),
            ("stability", StabilitySection),
            ("matching", MatchingSection),
        )
        for key, kind in sections:
            if values.get(key) is not None:
                values[key] = dataclass_from_table(kind, values[key], f"{where}: [{key}]")
        if isinstance(values.get("seeds"), list):
            values["seeds"] = tuple(values["seeds"])
        return dataclass_from_table(cls, values, where)

    @classmethod
    def load(cls, source: str | os.PathLike[str]) -> "Experiment":
        """Read a preset by name or a TOML file by path.

        Raises
        ------
        InputError
            If there is no such preset or file, or its contents cannot be used.
        """
        return cls.from_table(*preset_or_file(source, presets(), "experiment", locate))


def locate(table: dict[str, Any], folder: Path) -> None:
    """Make paths absolute: of data sets, of Python files of methods, and the folder of an external method."""
    for each in filter(_is_named, _tables(table, "dataset")):
        each["name"] = _located(each["name"], folder, is_data)
    for each in filter(_is_named, _tables(table, "method")):
        file, colon, attribute = each["name"].rpartition(":")
        if file.endswith(".py"):
            each.setdefault("label", each["name"])
            each["name"] = _located(file, folder, Path.is_file) + colon + attribute
        elif each["name"] == "external":
            for options in (each, each.get("options")):
                if isinstance(options, dict) and isinstance(options.get("folder"), str):
                    options["folder"] = _located(options["folder"], folder, Path.is_dir)


def portable(table: Mapping[str, Any]) -> dict[str, Any]:
    """The settings with files and folders by their names, to lie beside the TOML file: what `locate` undoes.

    Equal wherever the files are, and without the names of anybody's folders.
    """
    found = copy.deepcopy(dict(table))
    for each in filter(_is_named, _tables(found, "dataset")):
        each["name"] = _beside(each["name"])
    for each in filter(_is_named, _tables(found, "method")):
        file, colon, attribute = each["name"].rpartition(":")
        if file.endswith(".py"):
            each["name"] = _beside(file) + colon + attribute
        options = each.get("options")
        if (
            each["name"] == "external"
            and isinstance(options, dict)
            and isinstance(options.get("folder"), str)
        ):
            options["folder"] = _beside(options["folder"])
    return found


def _beside(name: str) -> str:
    """``./file`` for the absolute path of a file, which no built-in name is; else the name."""
    path = Path(name)
    return f"./{path.name}" if path.is_absolute() and path.name else name


def _tables(table: Mapping[str, Any], key: str) -> Sequence[Any]:
    found = table.get(key)
    return found if isinstance(found, list | tuple) else ()


def _is_named(each: Any) -> bool:
    return isinstance(each, dict) and isinstance(each.get("name"), str)


def _located(name: str, folder: Path, is_there: Callable[[Path], bool]) -> str:
    """The absolute path of what lies in the TOML file's folder or else in the current one; else the name.

    A built-in name stays what it is, whatever lies there (`datasets_gen.registry.is_folder`).
    """
    places = [folder / name, Path(name)] if name and name not in names() else []
    found = [path for path in places if is_there(path)]
    return str(found[0].resolve()) if found else name


def _list(values: Mapping[str, Any], key: str, where: str) -> Iterable[Any]:
    found = values.get(key, ())
    expect(isinstance(found, list | tuple), f"{where}: write [[{key}]], with two brackets")
    return found


def _method(table: Any, where: str) -> MethodSection:
    """A method's table holds its options beside its name; `label` defaults to the name."""
    expect(
        isinstance(table, Mapping) and isinstance(table.get("name"), str),
        f"{where} needs a name, got {table!r}",
    )
    given = table.get("options", {})
    expect(isinstance(given, Mapping), f"{where}: options must be a table, got {given!r}")
    options = {key: value for key, value in table.items() if key not in ("name", "label", "options")}
    return MethodSection(
        name=table["name"],
        label=str(table.get("label", table["name"])),
        options={**given, **options},
    )


def _product(sweep: Mapping[str, tuple[Any, ...]]) -> list[dict[str, Any]]:
    return [dict(zip(sweep, values, strict=True)) for values in itertools.product(*sweep.values())]


def _named(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{key} {value}" for key, value in values.items()) or "scan"


def _regime(base: ScanCondition, values: Mapping[str, Any], name: str) -> Regime:
    """Values apply to both clouds, or to one with a prefix."""
    both = {key: value for key, value in values.items() if not key.startswith(("source.", "target."))}
    sides = {
        side: base.with_values(
            both | {key.partition(".")[2]: v for key, v in values.items() if key.startswith(f"{side}.")}
        )
        for side in ("source", "target")
    }
    return Regime(name=name, **sides)
