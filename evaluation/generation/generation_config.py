"""Settings of generated training data: the sections of experiments, and what differs from scan to scan.

A file has ``[[dataset]]`` (`DatasetSection`) and ``[scan]`` (`ScanCondition`) as in an experiment, ``[draw]``
(`DrawSection`), and ``name``, ``description``, ``seed``, ``validation``, ``held_out`` and ``timeout`` at the
top.
"""

import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any, Literal

from datasets_gen.values import check_count, check_seed, check_types
from evaluation.experiment.config_sections import SURFACE, DatasetSection, ScanCondition, as_sweep
from evaluation.experiment.experiment import locate
from evaluation.experiment.presets import packaged_toml, preset_or_file
from evaluation.experiment.subject_plan import scanner_settings
from evaluation.experiment.toml_tables import dataclass_from_table, expect, reject_unknown, to_toml
from scanner_sim import ScannerConfig, presets
from scanner_sim.optics.viewpoints import matrices

POINTS = 2048
"""Points per sample, unless ``[scan]`` says otherwise."""
MOST_VALIDATION = 0.5
"""Largest share of the subjects that is kept for validation."""


@dataclass(frozen=True, kw_only=True)
class DrawSection:
    """What differs from scan to scan, beside the subject and the pose."""

    threshold: tuple[float, ...] = (0.2, 0.9)
    """Smallest and largest tau; the range is divided evenly among the samples of a render."""
    per_render: int = 4
    """Samples, with different thresholds, of what the scanner acquires once: a render takes most time."""
    turn: Literal["none", "up", "any"] = "up"
    """How the viewpoints are turned about the body, at random for each render: not at all, about the axis
    that is up, or about any axis."""
    sweep: Mapping[str, tuple[Any, ...]] = field(default_factory=dict)
    """Values by key of the scan condition; each render has one of each list, drawn at random."""

    def __post_init__(self) -> None:
        """Check types and ranges."""
        object.__setattr__(self, "threshold", tuple(self.threshold))
        object.__setattr__(self, "sweep", as_sweep(self.sweep))
        check_types(type(self), vars(self))
        low, high = self.threshold if len(self.threshold) == 2 else (1.0, 0.0)
        expect(
            0 < low <= high <= 1,
            f"threshold must be [lowest, highest] with 0 < lowest <= highest <= 1, got {[*self.threshold]!r}",
        )
        check_count(self.per_render, "per_render")
        expect("threshold" not in self.sweep, "give the range of tau as 'threshold', not in 'sweep'")


@dataclass(frozen=True, kw_only=True)
class GenerationConfig:
    """Everything that decides the samples of generated training data."""

    name: str
    description: str = ""
    dataset: tuple[DatasetSection, ...]
    scan: ScanCondition = field(default_factory=lambda: ScanCondition(points=POINTS))
    """Base of every scan; the threshold is drawn."""
    draw: DrawSection = field(default_factory=DrawSection)
    seed: int = 0
    validation: float = 0.1
    """Share of the samples, and of each data set's subjects, that make the split ``val``."""
    held_out: bool = False
    """Whether bodies and poses that are kept from tuning (`datasets_gen.registry.held_out`) may be used."""
    timeout: float = 120.0
    """Seconds per sample after which the work on a shard is stopped and recorded as a failure."""

    def __post_init__(self) -> None:
        """Check what concerns several sections, and what is passed on to the scanner."""
        expect(len(self.dataset) > 0, "no [[dataset]]: nothing to scan")
        check_seed(self.seed)
        expect(
            0 <= self.validation <= MOST_VALIDATION,
            f"validation must lie in [0, {MOST_VALIDATION:g}], got {self.validation!r}",
        )
        expect(self.timeout > 0, f"timeout must be positive, got {self.timeout!r}")
        conditions = [
            self.scan.with_values({key: value}) for key, values in self.draw.sweep.items() for value in values
        ]
        for condition in (self.scan, *conditions):
            self._check_scanner(condition)

    def _check_scanner(self, condition: ScanCondition) -> None:
        if condition.views == SURFACE:
            return
        reject_unknown(condition.scanner, [*(f.name for f in fields(ScannerConfig)), presets.KEY], "scanner")
        ScannerConfig.from_dict(scanner_settings(condition))
        expect(
            self.draw.turn == "none" or matrices(condition.views) is None,
            'viewpoints given as matrices are not turned; give turn = "none" under [draw]',
        )

    def as_dict(self) -> dict[str, Any]:
        """Every setting, as tables that `from_table` reads back."""
        table = asdict(self)
        del table["scan"]["threshold"]
        return table

    def to_toml(self) -> str:
        """Every setting as the text of a TOML file that `load` reads back."""
        return to_toml(self.as_dict())

    @classmethod
    def from_table(cls, table: Mapping[str, Any], where: str = "generation") -> "GenerationConfig":
        """Build from parsed TOML.

        Raises
        ------
        InputError
            If a key is unknown (the nearest valid one is named) or a value cannot be used.
        """
        values = dict(table)
        reject_unknown(values, [f.name for f in fields(cls)], where)
        sections = values.get("dataset", ())
        expect(isinstance(sections, list | tuple), f"{where}: write [[dataset]], with two brackets")
        values["dataset"] = tuple(
            dataclass_from_table(DatasetSection, each, f"{where}: [[dataset]]") for each in sections
        )
        if "scan" in values:
            values["scan"] = _scan_section(values["scan"], f"{where}: [scan]")
        if "draw" in values:
            values["draw"] = dataclass_from_table(DrawSection, values["draw"], f"{where}: [draw]")
        return dataclass_from_table(cls, values, where)

    @classmethod
    def load(cls, source: str | os.PathLike[str]) -> "GenerationConfig":
        """Read a preset by name or a TOML file by path.

        Raises
        ------
        InputError
            If there is no such preset or file, or its contents cannot be used.
        """
        return cls.from_table(*preset_or_file(source, generation_presets(), "generation", locate))


def _scan_section(table: Any, where: str) -> ScanCondition:
    """The section with its own default number of points, and without a threshold, which is drawn."""
    expect(isinstance(table, Mapping), f"{where} must be a table, got {table!r}")
    expect("threshold" not in table, f"{where}: give the range of tau as 'threshold' under [draw]")
    return dataclass_from_table(ScanCondition, {"points": POINTS, **table}, where)


def generation_presets() -> dict[str, str]:
    """Text (TOML) of every packaged configuration, by name."""
    return packaged_toml("evaluation.generation")
