"""`MatchConfig`: the settings of matching."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, Literal

from datasets_gen.records import InputError
from datasets_gen.values import CheckedSettings, check_count
from medial.departures import Departures
from medial.matching.registration.evidence import KINDS, Kind

FEWEST_NODES = 8
"""A deformation with fewer nodes than this does not bend where a body bends."""
_LEAST = {
    "samples": 2,
    "times": 1,
    "landmarks": 1,
    "restarts": 1,
    "partners": 1,
    "nodes": FEWEST_NODES,
    "fine_nodes": FEWEST_NODES,
    "finalists": 1,
}
"""Settings that are counts, and their least values."""
_MOST = 100_000
"""Of any of them: one that no machine has the memory or the years for."""


@dataclass(frozen=True, kw_only=True)
class MatchConfig(CheckedSettings):
    """Settings of `medial.match`; the defaults are the best ones measured, `paper()` those of Sec. 4."""

    kind: ClassVar[str] = "match setting"
    samples: int = 500
    """Samples S_P and S_Q; a cloud with fewer points is used whole. By spectral clustering (Sec. 4) or, with
    selection ``"fit"``, by clusters that are near in space as well: they have to cover the surface. Those are
    of the points that a registration sees, 8,000 at most (`medial.matching.prepared.cover_of`)."""
    times: int = 25
    """Number of times at which m_t is compared, spaced evenly in their logarithm."""
    candidates: float = 0.05
    """Fraction of S_Q, nearest in signature, that Eq. 16 searches; in (0, 1]."""
    landmarks: int = 5
    """Landmark correspondences per restart found by Eq. 16; those found by path length have up to nine."""
    restarts: int = 8
    """First landmarks that are tried."""
    starts: Literal["random", "spread"] = "spread"
    """First landmarks: drawn at random, or farthest points of the diffusion map."""
    partners: int = 3
    """Partners tried for each first landmark, apart from each other: left for right, arm for leg."""
    paths: bool = True
    """Also try landmark sets that agree in medial path length (`landmarks.path_landmarks`)."""
    selection: Literal["cost", "fit"] = "fit"
    """What picks a map: the lowest cost of Eq. 17, or how well the deformed source fits the target."""
    both_ways: bool = True
    """Also deform the target onto the source; the better fit wins. Only with selection ``"fit"``."""
    by_diffusion: bool = True
    """Try landmark sets by Eq. 16. Without, those by path length and rigid motions are left: what diffusion
    is worth. Only with selection ``"fit"``."""
    rigid_starts: bool = True
    """Where no landmark set makes the surfaces meet, start from rigid motions too, principal axes on
    principal axes; only with selection ``"fit"``."""
    recombine: bool = True
    """Exchange parts between maps before one is picked; only with selection ``"fit"``."""
    refine: Literal["none", "spectral", "deform"] = "deform"
    """Dense map: Eq. 17 (or the quick fit), spectral refinement (ZoomOut), or the settled deformation."""
    nodes: int = 80
    """Nodes of the quick deformations."""
    fine_nodes: int = 200
    """Nodes of the final deformation."""
    finalists: int = 8
    """Maps of nearly the best score that are deformed finely before one is picked."""
    evidence: tuple[Kind, ...] = KINDS
    """What maps are compared by, beside surface that meets (`registration.evidence`): ``"visibility"`` (what
    the other scan could not have seen costs nothing), ``"strain"`` (and torn edges), ``"paths"`` (their
    lengths), ``"medial"`` (the medial balls of both meet). Only with selection ``"fit"``."""
    departures: Departures | None = None
    """What differs from the equations, or ``"all"``, ``"none"``, or truth values by name; None takes what the
    operators were built with. Matching looks at `area_normalised_kernels` (Eqs. 16-17) and, in
    `medial.intrinsic_symmetry`, at `mirrored_symmetry` (Sec. 5.2)."""

    def __post_init__(self) -> None:
        """Check types and ranges."""
        self.check_types()
        if self.departures is not None:
            object.__setattr__(self, "departures", Departures.of(self.departures))
        for name, low in _LEAST.items():
            check_count(getattr(self, name), f"match setting {name}", low, _MOST)
        object.__setattr__(self, "evidence", tuple(self.evidence))
        if not 0 < self.candidates <= 1:
            raise InputError(f"match setting candidates must lie in (0, 1], got {self.candidates!r}")

    @classmethod
    def paper(cls, departures: Departures | None = None) -> "MatchConfig":
        """Settings of Sec. 4: 700 samples, 25 times, top 5 %, 5 landmarks, 10 restarts, lowest Eq. 17 cost.

        Parameters
        ----------
        departures
            As the field: Eqs. 16 and 17 are as written where the operators are.
        """
        return cls(
            samples=700,
            times=25,
            candidates=0.05,
            landmarks=5,
            restarts=10,
            starts="random",
            partners=1,
            paths=False,
            selection="cost",
            both_ways=False,
            rigid_starts=False,
            recombine=False,
            refine="none",
            departures=departures,
        )

    @classmethod
    def of(cls, value: "MatchConfig | str | None", departures: Departures) -> "MatchConfig":
        """Complete settings from what a caller gives.

        Parameters
        ----------
        value
            Settings, ``"default"`` or ``"paper"``; None is ``"paper"`` if all departures are switched off.
        departures
            Of the operators, for settings that leave them open.

        Raises
        ------
        InputError
            If it is none of these.
        """
        if value is None:
            value = "paper" if departures == Departures.none() else "default"
        if value in ("default", "paper"):
            value = cls() if value == "default" else cls.paper()
        if not isinstance(value, cls):
            raise InputError(f"match config is {value!r}; give 'default', 'paper' or a MatchConfig")
        return value if value.departures else replace(value, departures=departures)

    @classmethod
    def from_dict(cls, settings: Mapping[str, Any]) -> "MatchConfig":
        """Settings by name over the defaults, as read from a TOML file.

        Raises
        ------
        InputError
            If a name is unknown or a value is out of range.
        """
        return cls(**settings)
