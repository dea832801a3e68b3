"""What matching is told (`MatchConfig`) and what it returns (`Matching`)."""

import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError, load_record, save_record

_COUNTS = (
    "samples",
    "times",
    "first_mode",
    "landmarks",
    "restarts",
    "partners",
    "nodes",
    "fine_nodes",
    "finalists",
)
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
    """Logarithmic time scales."""
    first_mode: int = 1
    """The longest time is 4 ln 10 over the eigenvalue of this (1-based) positive mode; 1 is [SOG09]."""
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

    def __post_init__(self) -> None:
        """Check ranges and choices."""
        for name in _COUNTS:
            value, low = getattr(self, name), 8 if name.endswith("nodes") else 1
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
    def paper(cls) -> "MatchConfig":
        """Sec. 4 as written: 700 samples, 25 times, top 5 %, 5 landmarks, 10 restarts, lowest Eq. 17 cost."""
        return cls(
            samples=700,
            times=25,
            first_mode=1,
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
        )

    @classmethod
    def from_dict(cls, settings: Mapping[str, Any]) -> "MatchConfig":
        """Settings by name over the defaults, as read from a TOML file.

        Raises
        ------
        InputError
            If a name is unknown or a value is out of range.
        """
        known = [f.name for f in fields(cls)]
        unknown = sorted(set(settings) - set(known))
        if unknown:
            raise InputError(f"unknown match setting {unknown[0]!r}; known are {known}")
        return cls(**settings)


@dataclass(frozen=True)
class Matching:
    """A dense correspondence from one cloud to another.

    Attributes
    ----------
    source_to_target : (n_source,) int64
        Target point of every source point.
    landmarks : (L, 2) int64
        Source point ids of the landmarks it grew from, and their targets in the final map.
    cost : float
        Mean residual of Eq. 17 over the samples, in units of the signature; NaN if path length found
        the landmarks.
    confidence : (n_source,) float64
        In [0, 1].
    restarts : dict of arrays
        One entry per landmark set: ``first`` (source point id of the first landmark), ``partner`` (its
        target), ``paths`` (found by path length, not by Eq. 16), ``backward`` (tried by deforming the target
        onto the source), ``cost`` (of Eq. 17, over the samples of what is deformed; NaN for path length),
        ``score`` (higher is better; what picked the set), ``chosen`` (bool).
    flip : str
        ``"kept"``, ``"flipped"`` (the mirrored counterpart was taken) or ``"undecided"``.
    seed : int
    config : MatchConfig
    """

    source_to_target: NDArray[np.int64]
    landmarks: NDArray[np.int64]
    cost: float
    confidence: NDArray[np.float64]
    restarts: dict[str, NDArray[Any]]
    flip: str = "undecided"
    seed: int = 0
    config: MatchConfig = field(default_factory=MatchConfig)

    def __len__(self) -> int:
        """Return the number of source points."""
        return len(self.source_to_target)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as ``.npz``."""
        arrays: dict[str, NDArray[Any]] = {name: getattr(self, name) for name in _ARRAYS}
        arrays |= {_TABLE + name: column for name, column in self.restarts.items()}
        meta = {"cost": self.cost, "flip": self.flip, "seed": self.seed, "config": asdict(self.config)}
        save_record(path, "Matching", arrays, meta)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Matching":
        """Read a file written by `save`."""
        arrays, meta = load_record(path, "Matching")
        table = {
            name.removeprefix(_TABLE): arrays.pop(name) for name in list(arrays) if name.startswith(_TABLE)
        }
        meta["config"] = MatchConfig.from_dict(meta["config"])
        return cls(**arrays, **meta, restarts=table)


_ARRAYS = ("source_to_target", "landmarks", "confidence")
_TABLE = "restarts_"
