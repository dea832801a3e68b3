"""Sections of an experiment file: what is scanned, under which conditions, compared how."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

from datasets_gen.values import check_count, check_types
from evaluation.experiment.toml_tables import expect, expect_distinct, reject_unknown
from medial.operator import OPERATORS
from medial.validation import FEWEST_POINTS

SURFACE = "surface"
"""Instead of viewpoints: the mesh of a pose is sampled as it is, without the scanner."""
LARGEST_SCALE = 1e6
"""Largest factor by which a cloud may be scaled; the smallest is one over it."""


@dataclass(frozen=True, kw_only=True)
class DatasetSection:
    """One subject and the poses to use."""

    name: str
    """A built-in data set, or the path of a folder of meshes that share connectivity."""
    poses: tuple[str, ...] | int | str = "all"
    """Names; a number (the reference first, then the others in the data set's order); or ``"all"``."""
    options: Mapping[str, Any] = field(default_factory=dict)
    """Passed to `datasets_gen.load`."""

    def __post_init__(self) -> None:
        """Check types."""
        expect(self.name.strip() != "", "name is empty; give a data set or the path of a folder")
        if isinstance(self.poses, list):
            object.__setattr__(self, "poses", tuple(str(pose) for pose in self.poses))
        valid = (
            self.poses == "all"
            or isinstance(self.poses, tuple)
            or (isinstance(self.poses, int) and self.poses > 0)
        )
        if isinstance(self.poses, tuple):
            expect_distinct(self.poses, "poses")
        expect(valid, f"poses must be names, a positive number or 'all', got {self.poses!r}")


@dataclass(frozen=True, kw_only=True)
class ScanCondition:
    """How one cloud is made from one shape."""

    threshold: float = 0.3
    """Smallest accepted fitted peak, tau, in (0, 1]."""
    views: Any = 6
    """Viewpoints, as `scanner_sim.ScannerConfig.views`; or ``"surface"``: the mesh itself is sampled, without
    scanner and threshold, as for parts that are partial already."""
    points: int = 8000
    """Points kept by farthest-point sampling; a scan with fewer keeps all."""
    scanner: Mapping[str, Any] = field(default_factory=dict)
    """Further fields of `scanner_sim.ScannerConfig`."""
    rotation: float = 0.0
    """Angle in degrees by which the finished cloud is turned about a random axis."""
    scale: float = 1.0
    """Factor by which the finished cloud is scaled."""

    def __post_init__(self) -> None:
        """Check types, as sweeps replace single values, and ranges."""
        check_types(type(self), vars(self))
        expect(0 < self.threshold <= 1, f"threshold must lie in (0, 1], got {self.threshold!r}")
        check_count(self.points, "points", FEWEST_POINTS)
        expect(
            1 / LARGEST_SCALE <= self.scale <= LARGEST_SCALE,
            f"scale is {self.scale!r}; give one of {1 / LARGEST_SCALE:.0e} to {LARGEST_SCALE:.0e}",
        )
        reserved = {"views", "peak_threshold"} & set(self.scanner)
        expect(
            not reserved,
            f"give {', '.join(sorted(reserved))} as 'views' and 'threshold', not under 'scanner'",
        )
        expect(
            self.views != SURFACE or not self.scanner,
            f"views = {SURFACE!r} samples the mesh without a scanner; leave out {', '.join(self.scanner)}",
        )

    def with_values(self, values: Mapping[str, Any]) -> "ScanCondition":
        """A copy with some values replaced; ``"scanner.noise"`` names a field of the scanner."""
        plain = {key: value for key, value in values.items() if not key.startswith("scanner.")}
        inner = {key.partition(".")[2]: value for key, value in values.items() if key.startswith("scanner.")}
        reject_unknown(plain, [f.name for f in fields(ScanCondition)], "scan condition")
        extra = dict(plain.pop("scanner", {}))
        return replace(self, **plain, scanner={**self.scanner, **extra, **inner})


@dataclass(frozen=True, kw_only=True)
class Regime:
    """Conditions of the two clouds of a pair, under a name."""

    name: str
    source: ScanCondition
    target: ScanCondition


@dataclass(frozen=True, kw_only=True)
class OperatorsSection:
    """Operators that spectral methods share; each is built once per cloud."""

    modes: int = 300
    """Eigenpairs kept."""
    medial: Mapping[str, Any] = field(default_factory=dict)
    """Further arguments of `Diffusion.from_points` for the medial operator."""
    heat: Mapping[str, Any] = field(default_factory=dict)
    robust: Mapping[str, Any] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check ranges."""
        check_count(self.modes, "modes", 2)


@dataclass(frozen=True, kw_only=True)
class StabilitySection:
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
        reject_unknown(self.operators, OPERATORS, "stability", "operator")
        expect_distinct(self.operators, "operators")
        check_count(self.pairs, "pairs")
        check_count(self.times, "times")
        object.__setattr__(self, "sweep", as_sweep(self.sweep))


@dataclass(frozen=True, kw_only=True)
class MatchingSection:
    """Correspondence of pairs of poses under one or more regimes."""

    pairs: Any = "reference"
    """``"reference"`` (the rest pose to every other), ``"all"`` (every ordered pair), ``"chain"`` (each
    pose to the next), a number (that many ordered pairs, drawn by a fixed rule), or a list of [source,
    target]."""
    sweep: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    """Values by key of the scan condition, for both clouds, or one with ``source.`` or ``target.`` before."""
    regime: tuple[Mapping[str, Any], ...] = ()
    """Named regimes, after those of a sweep if there is one: ``name`` and values as in `sweep`, one each."""

    def __post_init__(self) -> None:
        """Lists to tuples, checked."""
        object.__setattr__(self, "sweep", as_sweep(self.sweep))
        object.__setattr__(self, "regime", tuple(dict(each) for each in self.regime))
        for each in self.regime:
            named = isinstance(each.get("name"), str) and bool(str(each["name"]).strip())
            expect(named, f"a regime needs a name, got {each!r}")
        if self.regime:
            expect_distinct([each["name"] for each in self.regime], "the list of regimes' names")
        if isinstance(self.pairs, list | tuple):
            pairs = tuple(tuple(pair) if isinstance(pair, list | tuple) else pair for pair in self.pairs)
            expect(all(isinstance(p, tuple) and len(p) == 2 for p in pairs), "pairs must be [source, target]")
            expect_distinct(pairs, "pairs")
            object.__setattr__(self, "pairs", pairs)
        else:
            number = isinstance(self.pairs, int) and not isinstance(self.pairs, bool) and self.pairs > 0
            known = self.pairs in ("reference", "all", "chain")
            expect(
                number or known,
                f"pairs must be reference, all, chain, a number or a list, got {self.pairs!r}",
            )


@dataclass(frozen=True, kw_only=True)
class MethodSection:
    """A method under the name it has in tables."""

    name: str
    """As in `evaluation.methods`, or ``"file.py:Class"`` or ``"module:Class"`` for your own."""
    label: str
    options: Mapping[str, Any] = field(default_factory=dict)


def as_sweep(table: Mapping[str, Any]) -> dict[str, tuple[Any, ...]]:
    """A sweep with its values checked and as tuples."""
    expect(isinstance(table, Mapping), f"sweep must be a table of lists, got {table!r}")
    for key, values in table.items():
        expect(
            isinstance(values, list | tuple) and len(values) > 0,
            f"sweep.{key} must be a list, got {values!r}",
        )
        expect_distinct(list(values), f"sweep.{key}")
    return {key: tuple(values) for key, values in table.items()}
