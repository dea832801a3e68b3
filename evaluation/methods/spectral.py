"""Matching by diffusion: one matcher, three operators. A comparison of these compares operators."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any, ClassVar

from datasets_gen.records import InputError
from evaluation.methods.base import Cloud, Method
from medial import MatchConfig, Matching, match

CONFIGS = {"default": MatchConfig, "paper": MatchConfig.paper}


@dataclass(frozen=True, kw_only=True)
class Spectral(Method):
    """Landmarks, extrapolation and refinement of `medial.match`, in the modes of one operator."""

    operator: ClassVar[str]

    config: str = "default"
    """``"default"`` (the best measured) or ``"paper"`` (Sec. 4 as written)."""
    settings: Mapping[str, Any] = field(default_factory=dict)
    """Fields of `medial.MatchConfig` over those of `config`."""

    def __post_init__(self) -> None:
        """Check the settings now, not hours into a sweep."""
        self.match_config()

    def match_config(self) -> MatchConfig:
        """The settings of the matcher."""
        if self.config not in CONFIGS:
            raise InputError(f"config must be one of {', '.join(CONFIGS)}, got {self.config!r}")
        return MatchConfig.from_dict({**asdict(CONFIGS[self.config]()), **self.settings})

    def match(self, source: Cloud, target: Cloud, seed: int) -> Matching:
        """Match in the modes of the operator."""
        return match(
            source.operators[self.operator], target.operators[self.operator], self.match_config(), seed
        )


class Medial(Spectral):
    """The paper's method: medial diffusion."""

    operator = "medial"
    operators = ("medial",)


class Heat(Spectral):
    """Heat kernel matching [OMMG10], Gaussian weights [BSW09], the same landmark search and refinement."""

    operator = "heat"
    operators = ("heat",)


class Robust(Spectral):
    """The same on the tufted Laplacian of point clouds [Sharp & Crane 2020]."""

    operator = "robust"
    operators = ("robust",)
