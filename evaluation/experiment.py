"""An experiment: which shapes, scanned how, matched by what. Read from TOML; frozen; complete.

Sections of the file (every key is a field below, with its default):

``[[dataset]]`` (`Dataset`), ``[scan]`` (`Condition`: the base from which sweeps deviate), ``[operators]``
(`Operators`), ``[stability]`` (`Stability`, Eq. 18), ``[matching]`` (`Matching`), ``[[method]]`` (`Method`),
and ``name``, ``description``, ``seeds``, ``timeout``, ``evaluated`` at the top.
"""

import itertools
import os
import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field, fields, replace
from importlib.resources import files
from pathlib import Path
from typing import Any

from datasets_gen.records import InputError
from evaluation.settings import build, expect, reject_unknown


@dataclass(frozen=True, kw_only=True)
class Dataset:
    """One subject and the poses to use."""

    name: str
    """A built-in data set, or the path of a folder of meshes that share connectivity."""
    poses: tuple[str, ...] | int | str = "all"
    """Names; a number (the reference first, then the others in the data set's order); or ``"all"``."""
    options: Mapping[str, Any] = field(default_factory=dict)
    """Passed to `datasets_gen.load`."""

    def __post_init__(self) -> None:
        """Check types."""
        if isinstance(self.poses, list):
            object.__setattr__(self, "poses", tuple(str(pose) for pose in self.poses))
        valid = (
            self.poses == "all"
            or isinstance(self.poses, tuple)
            or (isinstance(self.poses, int) and self.poses > 0)
        )
        expect(valid, f"poses must be names, a positive number or 'all', got {self.poses!r}")


@dataclass(frozen=True, kw_only=True)
class Condition:
    """How one cloud is made from one shape."""

    threshold: float = 0.3
    """Smallest accepted fitted peak, tau, in (0, 1]."""
    views: Any = 6
    """Viewpoints, as `scanner_sim.ScannerConfig.views`."""
    points: int = 8000
    """Points kept by farthest-point sampling; a scan with fewer keeps all."""
    scanner: Mapping[str, Any] = field(default_factory=dict)
    """Further fields of `scanner_sim.ScannerConfig`."""
    rotation: float = 0.0
    """Angle in degrees by which the finished cloud is turned about a random axis."""
    scale: float = 1.0
    """Factor by which the finished cloud is scaled."""

    def __post_init__(self) -> None:
        """Check ranges."""
        expect(0 < self.threshold <= 1, f"threshold must lie in (0, 1], got {self.threshold!r}")
        expect(
            isinstance(self.points, int) and self.points >= 1,
            f"points must be a positive number, got {self.points!r}",
        )
        expect(self.scale > 0, f"scale must be positive, got {self.scale!r}")
        reserved = {"views", "peak_threshold"} & set(self.scanner)
        expect(
            not reserved,
            f"give {', '.join(sorted(reserved))} as 'views' and 'threshold', not under 'scanner'",
        )

    def with_values(self, values: Mapping[str, Any]) -> "Condition":
        """A copy with some values replaced; ``"scanner.noise"`` names a field of the scanner."""
        plain = {key: value for key, value in values.items() if not key.startswith("scanner.")}
        inner = {key.partition(".")[2]: value for key, value in values.items() if key.startswith("scanner.")}
        reject_unknown(plain, [f.name for f in fields(Condition)], "scan condition")
        extra = dict(plain.pop("scanner", {}))
        return replace(self, **plain, scanner={**self.scanner, **extra, **inner})


@dataclass(frozen=True, kw_only=True)
class Regime:
    """Conditions of the two clouds of a pair, under a name."""

    name: str
    source: Condition
    target: Condition


@dataclass(frozen=True, kw_only=True)
class Operators:
    """Operators that spectral methods share; each is built once per cloud."""

    modes: int = 300
    """Eigenpairs kept."""
    medial: Mapping[str, Any] = field(default_factory=dict)
    """Further arguments of `Diffusion.from_points` for the medial operator."""
    heat: Mapping[str, Any] = field(default_factory=dict)
    robust: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check ranges."""
        expect(isinstance(self.modes, int) and self.modes > 1, f"modes must exceed 1, got {self.modes!r}")


@dataclass(frozen=True, kw_only=True)
class Stability:
    """The experiment of Sec. 5.1: Eq. 18 of scans of every pose against the well-sampled rest pose."""

    operators: tuple[str, ...] = ("medial", "heat")
    sweep: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    """Values by key of the scan condition; all combinations are run."""
    pairs: int = 10_000
    """|C| of Eq. 18."""
    times: int = 25
    """|T| of Eq. 18."""

    def __post_init__(self) -> None:
        """Lists to tuples, checked."""
        object.__setattr__(self, "operators", tuple(self.operators))
        reject_unknown(self.operators, ("medial", "heat", "robust"), "stability", "operator")
        object.__setattr__(self, "sweep", _sweep(self.sweep))


@dataclass(frozen=True, kw_only=True)
class Matching:
    """Correspondence of pairs of poses under one or more regimes."""

    pairs: Any = "reference"
    """``"reference"`` (the rest pose to every other), ``"all"`` (every ordered pair), ``"chain"`` (each
    pose to the next), a number (that many ordered pairs, drawn by a fixed rule), or a list of [source,
    target]."""
    sweep: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    """Values by key of the scan condition, for both clouds, or one with ``source.`` or ``target.`` before."""
    regime: tuple[Mapping[str, Any], ...] = ()
    """Named regimes instead of a sweep: ``name`` and values as in `sweep`, one each."""

    def __post_init__(self) -> None:
        """Lists to tuples, checked."""
        object.__setattr__(self, "sweep", _sweep(self.sweep))
        object.__setattr__(self, "regime", tuple(dict(each) for each in self.regime))
        expect(not (self.sweep and self.regime), "give 'sweep' or 'regime', not both")
        for each in self.regime:
            expect("name" in each, f"a regime needs a name, got {each!r}")
        if isinstance(self.pairs, list | tuple):
            pairs = tuple(tuple(pair) if isinstance(pair, list | tuple) else pair for pair in self.pairs)
            expect(all(isinstance(p, tuple) and len(p) == 2 for p in pairs), "pairs must be [source, target]")
            object.__setattr__(self, "pairs", pairs)
        else:
            number = isinstance(self.pairs, int) and self.pairs > 0
            known = self.pairs in ("reference", "all", "chain")
            expect(
                number or known,
                f"pairs must be reference, all, chain, a number or a list, got {self.pairs!r}",
            )


@dataclass(frozen=True, kw_only=True)
class Method:
    """A method under the name it has in tables."""

    name: str
    """As in `evaluation.methods`, or ``"file.py:Class"`` or ``"module:Class"`` for your own."""
    label: str
    options: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class Experiment:
    """Everything that decides a sweep's results."""

    name: str
    description: str = ""
    dataset: tuple[Dataset, ...]
    scan: Condition = field(default_factory=Condition)
    operators: Operators = field(default_factory=Operators)
    stability: Stability | None = None
    matching: Matching | None = None
    method: tuple[Method, ...] = ()
    seeds: tuple[int, ...] = (0,)
    timeout: float = 1800.0
    """Seconds after which a task is stopped and recorded as a failure."""
    evaluated: int = 2000
    """Points of each map, drawn once per pair, at which geodesic errors are measured."""

    def __post_init__(self) -> None:
        """Check what concerns several sections."""
        expect(len(self.dataset) > 0, "no [[dataset]]: nothing to scan")
        expect(len(self.seeds) > 0, "seeds is empty: nothing to run")
        expect(self.timeout > 0, f"timeout must be positive, got {self.timeout!r}")
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
            expect(labels.count(label) == 1, f"two methods are called {label!r}; give each its own label")
        self.stability_conditions()
        self.regimes()

    def stability_conditions(self) -> tuple[tuple[str, Condition], ...]:
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
        if self.matching.regime:
            named = [
                ({k: v for k, v in each.items() if k != "name"}, each["name"])
                for each in self.matching.regime
            ]
        else:
            named = [(values, _named(values)) for values in _product(self.matching.sweep)]
        return tuple(_regime(self.scan, values, name) for values, name in named)

    def as_dict(self) -> dict[str, Any]:
        """Every setting, as tables that `from_table` reads back."""
        return asdict(self)

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
            build(Dataset, each, f"{where}: [[dataset]]") for each in _list(values, "dataset", where)
        )
        values["method"] = tuple(
            _method(each, f"{where}: [[method]]") for each in _list(values, "method", where)
        )
        sections = (
            ("scan", Condition),
            ("operators", Operators),
            ("stability", Stability),
            ("matching", Matching),
        )
        for key, kind in sections:
            if values.get(key) is not None:
                values[key] = build(kind, values[key], f"{where}: [{key}]")
        if "seeds" in values:
            seeds = values["seeds"]
            expect(
                isinstance(seeds, list | tuple) and all(isinstance(s, int) for s in seeds),
                f"{where}: seeds must be a list of integers, got {seeds!r}",
            )
            values["seeds"] = tuple(seeds)
        return build(cls, values, where)

    @classmethod
    def load(cls, source: str | os.PathLike[str]) -> "Experiment":
        """Read a preset by name or a TOML file by path.

        Raises
        ------
        InputError
            If there is no such preset or file, or its contents cannot be used.
        """
        path = Path(source)
        known = presets()
        if path.suffix != ".toml":
            reject_unknown([str(source)], known, "experiment", "preset")
            text, where, folder = known[str(source)], f"preset {str(source)!r}", None
        else:
            try:
                text, where, folder = path.read_text(encoding="utf-8"), repr(str(source)), path.parent
            except OSError as error:
                raise InputError(
                    f"cannot read {str(source)!r}: {error.strerror}; presets: {', '.join(known)}"
                ) from error
        try:
            table = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise InputError(f"{where} is not valid TOML: {error}") from error
        table.setdefault("name", path.stem)
        return cls.from_table(_beside(table, folder), where)


def presets() -> dict[str, str]:
    """Text of every packaged experiment, by name."""
    found = [each for each in files("evaluation.presets").iterdir() if each.name.endswith(".toml")]
    return {
        each.name.removesuffix(".toml"): each.read_text(encoding="utf-8") for each in sorted(found, key=str)
    }


def _beside(table: dict[str, Any], folder: Path | None) -> dict[str, Any]:
    """Relative folders of data sets are meant from the TOML file's folder, if they exist there."""
    for each in table.get("dataset", []) if folder is not None else []:
        if isinstance(each, dict) and isinstance(each.get("name"), str) and folder is not None:
            beside = folder / each["name"]
            if beside.is_dir():
                each["name"] = str(beside.resolve())
    return table


def _list(values: Mapping[str, Any], key: str, where: str) -> Iterable[Any]:
    found = values.get(key, ())
    expect(isinstance(found, list | tuple), f"{where}: write [[{key}]], with two brackets")
    return found


def _method(table: Any, where: str) -> Method:
    """A method's table holds its options beside its name; `label` defaults to the name."""
    expect(
        isinstance(table, Mapping) and isinstance(table.get("name"), str),
        f"{where} needs a name, got {table!r}",
    )
    options = {key: value for key, value in table.items() if key not in ("name", "label", "options")}
    return Method(
        name=table["name"],
        label=str(table.get("label", table["name"])),
        options={**table.get("options", {}), **options},
    )


def _sweep(table: Mapping[str, Any]) -> dict[str, tuple[Any, ...]]:
    expect(isinstance(table, Mapping), f"sweep must be a table of lists, got {table!r}")
    for key, values in table.items():
        expect(
            isinstance(values, list | tuple) and len(values) > 0,
            f"sweep.{key} must be a list, got {values!r}",
        )
    return {key: tuple(values) for key, values in table.items()}


def _product(sweep: Mapping[str, tuple[Any, ...]]) -> list[dict[str, Any]]:
    return [dict(zip(sweep, values, strict=True)) for values in itertools.product(*sweep.values())]


def _named(values: Mapping[str, Any]) -> str:
    return ", ".join(f"{key} {value}" for key, value in values.items()) or "scan"


def _regime(base: Condition, values: Mapping[str, Any], name: str) -> Regime:
    """Values apply to both clouds, or to one with a prefix."""
    both = {key: value for key, value in values.items() if not key.startswith(("source.", "target."))}
    sides = {
        side: base.with_values(
            both | {key.partition(".")[2]: v for key, v in values.items() if key.startswith(f"{side}.")}
        )
        for side in ("source", "target")
    }
    return Regime(name=name, **sides)
