"""What matching is told (`MatchConfig`) and what it returns (`Matching`)."""

import os
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError, load_record, save_record


@dataclass(frozen=True, kw_only=True)
class MatchConfig:
    """Settings of `medial.match`; the defaults are the best ones measured, `paper()` is Sec. 4 as written."""

    samples: int = 700
    """Samples S_P and S_Q of spectral clustering; a cloud with fewer points is used whole."""
    times: int = 25
    """Logarithmic time scales."""
    first_mode: int = 1
    """The longest time is 4 ln 10 over the eigenvalue of this (1-based) positive mode; 1 is [SOG09]."""
    candidates: float = 0.05
    """Fraction of S_Q, nearest in signature, that Eq. 16 searches; in (0, 1]."""
    landmarks: int = 5
    """Landmark correspondences per restart."""
    restarts: int = 10
    """First landmarks that are tried."""

    def __post_init__(self) -> None:
        """Check ranges."""
        for name, low in (("samples", 1), ("times", 1), ("first_mode", 1), ("landmarks", 1), ("restarts", 1)):
            if getattr(self, name) < low:
                raise InputError(f"match setting {name} must be at least {low}, got {getattr(self, name)!r}")
        if not 0 < self.candidates <= 1:
            raise InputError(f"match setting candidates must lie in (0, 1], got {self.candidates!r}")

    @classmethod
    def paper(cls) -> "MatchConfig":
        """Sec. 4 as written: 700 samples, 25 times, top 5 %, 5 landmarks, 10 restarts, lowest Eq. 17 cost."""
        return cls(samples=700, times=25, first_mode=1, candidates=0.05, landmarks=5, restarts=10)

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
        Source and target point ids of the landmarks it grew from.
    cost : float
        Mean residual of Eq. 17 over the samples, in units of the signature.
    confidence : (n_source,) float64
        In [0, 1].
    restarts : dict of arrays
        One entry per restart: ``first`` (source point id of the first landmark), ``partner`` (its target),
        ``cost`` (Eq. 17), ``score`` (higher is better; what picked the restart), ``chosen`` (bool).
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
