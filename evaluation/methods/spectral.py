"""Matching by diffusion: one matcher, three operators. A comparison of these compares operators."""

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

from evaluation.experiment.toml_tables import expect, reject_unknown
from evaluation.methods.base import Method, MethodInput
from medial import Departures, MatchConfig, Matching, match
from medial.departures import ALL_DEPARTURES
from medial.operator import OPERATORS

SETTINGS = tuple(each.name for each in fields(MatchConfig))
"""Of the matcher: options of these methods by themselves, or together as `Spectral.settings`."""


@dataclass(frozen=True, kw_only=True)
class Spectral(Method):
    """Landmarks, extrapolation and refinement of `medial.match`, in the modes of one operator."""

    operator: str = "medial"
    """``"medial"`` (the paper), ``"heat"`` (Gaussian weights [BSW09], so heat kernel matching [OMMG10]) or
    ``"robust"`` (the tufted Laplacian [Sharp & Crane 2020])."""
    config: str | None = None
    """``"default"`` (the best measured) or ``"paper"`` (settings of Sec. 4); None is ``"paper"`` where the
    operators have no departures."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    """Fields of `medial.MatchConfig` over those of `config`; departures are those of the operators."""

    @classmethod
    def from_options(cls, options: Mapping[str, Any]) -> "Spectral":
        """The method with its options, among which settings of the matcher may stand by themselves.

        Raises
        ------
        InputError
            If an option is unknown, given twice, or refused.
        """
        own = {each.name for each in fields(cls)}
        loose = {name: value for name, value in options.items() if name not in own}
        reject_unknown(loose, own | set(SETTINGS), f"method {cls.__name__}")
        within = options.get("settings", {})
        for name in loose:
            expect(
                not isinstance(within, Mapping) or name not in within,
                f"method {cls.__name__}: {name} is given twice, once in settings; give it once",
            )
        table = {name: value for name, value in options.items() if name in own}
        if loose and isinstance(within, Mapping):
            table["settings"] = {**within, **loose}
        made = super().from_options(table)
        assert isinstance(made, cls)
        return made

    def __post_init__(self) -> None:
        """Check the settings now, not hours into a sweep."""
        reject_unknown([self.operator], OPERATORS, "method", "operator")
        reject_unknown([self.config] if self.config else [], ("default", "paper"), "method", "config")
        expect(
            "departures" not in self.settings,
            "departures belong to the operators, not to a method's settings: "
            "give departures at the top of the experiment, or match --departures",
        )
        reject_unknown(self.settings, SETTINGS, "method settings")
        self.match_config()

    @property
    def operators(self) -> tuple[str, ...]:
        """The one whose modes it works in."""
        return (self.operator,)

    def match_config(self, departures: Departures = ALL_DEPARTURES) -> MatchConfig:
        """The settings of the matcher on operators with some departures from the paper."""
        return replace(MatchConfig.of(self.config, departures), **self.settings)

    def match(self, source: MethodInput, target: MethodInput, seed: int) -> Matching:
        """Match in the modes of the operator."""
        here, there = source.operators[self.operator], target.operators[self.operator]
        return match(here, there, self.match_config(here.departures), seed)


@dataclass(frozen=True, kw_only=True)
class Medial(Spectral):
    """The paper's method: medial diffusion."""


@dataclass(frozen=True, kw_only=True)
class Heat(Spectral):
    """Heat kernel matching [OMMG10], given the same landmark search and refinement."""

    operator: str = "heat"


@dataclass(frozen=True, kw_only=True)
class Robust(Spectral):
    """The same on the tufted Laplacian of point clouds."""

    operator: str = "robust"
