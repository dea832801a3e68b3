"""`MatchConfig`: the settings of matching."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Literal

from datasets_gen.records import InputError
from medial.departures import ALL_DEPARTURES, Departures

FEWEST_NODES = 8
"""A deformation with fewer nodes than this does not bend where a body bends."""
_LEAST = {
    "samples": 1,
    "times": 1,
    "landmarks": 1,
    "restarts": 1,
    "partners": 1,
    "nodes": FEWEST_NODES,
    "fine_nodes": FEWEST_NODES,
    "finalists": 1,
}
"""Settings that are counts, and their least values."""
_CHOICES = {
    "starts": ("random", "spread"),
    "selection": ("cost", "fit"),
    "refine": ("none", "spectral", "deform"),
}


@dataclass(frozen=True, kw_only=True)
class MatchConfig:
    """Settings of `medial.match`; the defaults are the best ones measured, `paper()` is Sec. 4 as written."""

    samples: int = 500
    """Samples S_P and S_Q; a cloud with fewer points is used whole. By spectral clustering (Sec. 4) or, with
    selection ``"fit"``, by clusters that are near in space as well: they have to cover the surface."""
    times: int = 25
    """Number of times at which m_t is compared, spaced evenly in their logarithm."""
    candidates: float = 0.05
    """Fraction of S_Q, nearest in signature, that Eq. 16 searches; in (0, 1]."""
    landmarks: int = 5
    """Landmark correspondences per restart."""
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
    finalists: int = 3
    """Maps of nearly the best score that are deformed finely before one is picked."""
    departures: Departures = ALL_DEPARTURES
    """What differs from the equations. Matching looks at `area_normalised_kernels` (Eqs. 16-17) and, in
    `medial.intrinsic_symmetry`, at `mirrored_symmetry` (Sec. 5.2)."""

    def __post_init__(self) -> None:
        """Check ranges and choices."""
        for name, low in _LEAST.items():
            value = getattr(self, name)
            if not isinstance(value, int) or isinstance(value, bool) or value < low:
                raise InputError(f"match setting {name} must be an integer of at least {low}, got {value!r}")
        for name, choices in _CHOICES.items():
            if getattr(self, name) not in choices:
                raise InputError(
                    f"match setting {name} must be one of {choices}, got {getattr(self, name)!r}"
                )
        if not 0 < self.candidates <= 1:
            raise InputError(f"match setting candidates must lie in (0, 1], got {self.candidates!r}")

    @classmethod
    def paper(cls, departures: Departures | None = None) -> "MatchConfig":
        """Sec. 4 as written: 700 samples, 25 times, top 5 %, 5 landmarks, 10 restarts, lowest Eq. 17 cost.

        Parameters
        ----------
        departures
            ``Departures.none()`` also takes m_t in the cloud's own units, as Eqs. 16 and 17 do.
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
            departures=departures or ALL_DEPARTURES,
        )

    @classmethod
    def from_dict(cls, settings: Mapping[str, Any]) -> "MatchConfig":
        """Settings by name over the defaults, as read from a TOML file.

        Parameters
        ----------
        settings
            `departures` may be ``"all"``, ``"none"`` or truth values by name.

        Raises
        ------
        InputError
            If a name is unknown or a value is out of range.
        """
        known = [f.name for f in fields(cls)]
        unknown = sorted(set(settings) - set(known))
        if unknown:
            raise InputError(f"unknown match setting {unknown[0]!r}; known are {known}")
        departures = Departures.of(settings.get("departures", ALL_DEPARTURES))
        return cls(**{**settings, "departures": departures})
