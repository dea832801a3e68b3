"""Matching by diffusion: one matcher, three operators. A comparison of these compares operators."""

from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any

from evaluation.experiment.toml_tables import reject_unknown
from evaluation.methods.base import Method, MethodInput
from medial import MatchConfig, Matching, match
from medial.operator import OPERATORS

CONFIGS: dict[str, Callable[[], MatchConfig]] = {"default": MatchConfig, "paper": MatchConfig.paper}


@dataclass(frozen=True, kw_only=True)
class Spectral(Method):
    """Landmarks, extrapolation and refinement of `medial.match`, in the modes of one operator."""

    operator: str = "medial"
    """``"medial"`` (the paper), ``"heat"`` (Gaussian weights [BSW09], so heat kernel matching [OMMG10]) or
    ``"robust"`` (the tufted Laplacian [Sharp & Crane 2020])."""
    config: str = "default"
    """``"default"`` (the best measured) or ``"paper"`` (Sec. 4 as written)."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    """Fields of `medial.MatchConfig` over those of `config`."""

    def __post_init__(self) -> None:
        """Check the settings now, not hours into a sweep."""
        reject_unknown([self.operator], OPERATORS, "method", "operator")
        self.match_config()

    @property
    def operators(self) -> tuple[str, ...]:
        """The one whose modes it works in."""
        return (self.operator,)

    def match_config(self) -> MatchConfig:
        """The settings of the matcher."""
        reject_unknown([self.config], CONFIGS, "method", "config")
        reject_unknown(self.settings, [f.name for f in fields(MatchConfig)], "method settings")
        return MatchConfig.from_dict({**asdict(CONFIGS[self.config]()), **self.settings})

    def match(self, source: MethodInput, target: MethodInput, seed: int) -> Matching:
        """Match in the modes of the operator."""
        return match(
            source.operators[self.operator], target.operators[self.operator], self.match_config(), seed
        )


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
