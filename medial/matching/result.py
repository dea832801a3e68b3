"""`Matching`: a dense correspondence between two clouds, and its file."""

import os
from dataclasses import asdict, dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.record_arrays import check_ids, check_layout, check_values
from datasets_gen.records import InputError, load_record, save_record, unpacking
from medial.matching.config import MatchConfig

Int = NDArray[np.int64]
Float = NDArray[np.float64]

UNCHECKED = "unchecked"
"""The mirror check of a map that no deformation decided on."""
CONFIDENT = 0.5
"""Confidence from which a point counts as matched."""


@dataclass(frozen=True)
class Alternative:
    """A map that may be right instead of the chosen one, such as the body turned by half a turn.

    Attributes
    ----------
    probability : float
        In (0, 1); that of the chosen map is `Matching.probability`, and all add up to at most 1.
    source_to_target : (n_source,) int64
        Target point of every source point.
    confidence : (n_source,) float64
        In [0, 1]; not more than the probability where it differs from the chosen map.
    """

    probability: float
    source_to_target: Int
    confidence: Float


@dataclass(frozen=True, repr=False)
class Matching:
    """A dense correspondence from one cloud to another.

    Attributes
    ----------
    source_to_target : (n_source,) int64
        Target point of every source point; -1 where a method finds none.
    landmarks : (L, 2) int64
        Source and target point ids of the landmarks that the map grew from: `MatchConfig.landmarks` of them
        by Eq. 16, or up to nine if a set by path length was chosen. The targets are the partners that
        Eq. 16 found where Eq. 17 alone made the map, as in the paper (selection ``"cost"`` without
        deformation). Where a deformation made it, they are where the final map sends the source landmarks.
        Landmarks given to `medial.extrapolate` stay as given.
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
    mirror_check : str
        Whether the deformation confirms the map of the lowest Eq. 17 cost, which is mirrored as often as not.
        It is no error, and says nothing of a symmetry:
        ``"agrees"`` (it took that map), ``"overruled"`` (it took another one), ``"undecided"`` (another map
        fits about as well) or ``"unchecked"`` (no deformation was tried).
    seed : int
    config : MatchConfig
    source_points, target_points : (n, 3) float64, optional
        The clouds, in their own units, where a file holds them.
    about : dict
        Further facts for the record, such as the method; values that JSON can hold.
    probability : float
        That the chosen map, or one that differs from it by no more than a limb, is the right one among those
        found; NaN where nothing was compared.
    alternatives : tuple of Alternative
        Maps that are less probable, though not by much; the most probable first.
    """

    source_to_target: Int
    landmarks: Int
    cost: float
    confidence: Float
    restarts: dict[str, NDArray[Any]]
    mirror_check: str = UNCHECKED
    seed: int = 0
    config: MatchConfig = field(default_factory=MatchConfig)
    source_points: Float | None = None
    target_points: Float | None = None
    about: dict[str, Any] = field(default_factory=dict)
    probability: float = float("nan")
    alternatives: tuple[Alternative, ...] = ()

    def __len__(self) -> int:
        """Return the number of source points."""
        return len(self.source_to_target)

    def __repr__(self) -> str:
        """Say in one line how many points are matched, and how surely."""
        sure = float(self.confidence.mean()) if len(self) else 0.0
        doubt = ", mirror check undecided" if self.mirror_check == "undecided" else ""
        if self.alternatives:
            likely = " ".join(f"{each.probability:.2f}" for each in self.alternatives)
            doubt += f", {self.probability:.2f} against {likely} for other maps"
        counts = f"{len(self)} points, {len(self.landmarks)} landmarks"
        return f"Matching({counts}, mean confidence {sure:.2f}{doubt})"

    def as_alternatives(self) -> "list[Matching]":
        """Each alternative as a map of its own.

        Returns
        -------
        list of Matching
            With the landmarks where it sends them.
        """
        return [
            replace(
                self,
                source_to_target=each.source_to_target,
                landmarks=np.column_stack([starts, each.source_to_target[starts]]),
                confidence=each.confidence,
                probability=each.probability,
                alternatives=(),
            )
            for starts in [self.landmarks[:, 0]]
            for each in self.alternatives
        ]

    def extended(
        self, nearest: Int, source_ids: Int, target_ids: Int, stray: NDArray[np.bool_] | None = None
    ) -> "Matching":
        """The map between the whole clouds that the matched points were picked from.

        Parameters
        ----------
        nearest : (N_source,) int64
            For every point of the whole source, the matched source point (in [0, n_source)) that it follows.
        source_ids, target_ids : (n_source,), (n_target,) int64
            Point ids of the matched points in the whole clouds.
        stray : (N_source,) bool, optional
            Points far from all others, whose confidence is 0.

        Returns
        -------
        Matching
            All its point ids are those of the whole clouds.
        """

        def whole(matched: Int) -> Int:
            image = np.where(matched < 0, -1, target_ids[matched])
            return np.asarray(image[nearest], dtype=np.int64)

        def belief(confidence: Float) -> Float:
            everywhere = np.asarray(confidence[nearest], dtype=np.float64)
            return everywhere if stray is None else np.where(stray, 0.0, everywhere)

        restarts = dict(self.restarts)
        for name, ids in (("first", source_ids), ("partner", target_ids)):
            if name in restarts:
                restarts[name] = ids[restarts[name]]
        return replace(
            self,
            source_to_target=whole(self.source_to_target),
            alternatives=tuple(
                Alternative(each.probability, whole(each.source_to_target), belief(each.confidence))
                for each in self.alternatives
            ),
            confidence=belief(self.confidence),
            landmarks=np.column_stack([source_ids[self.landmarks[:, 0]], target_ids[self.landmarks[:, 1]]]),
            restarts=restarts,
        )

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as ``.npz``."""
        arrays: dict[str, NDArray[Any]] = {name: getattr(self, name) for name in _ARRAYS}
        arrays |= {name: cloud for name in _CLOUDS if (cloud := getattr(self, name)) is not None}
        arrays |= {_TABLE + name: column for name, column in self.restarts.items()}
        if self.alternatives:
            arrays[_OTHERS] = np.stack([each.source_to_target for each in self.alternatives])
            arrays[_OTHERS_CONFIDENCE] = np.stack([each.confidence for each in self.alternatives])
            arrays[_PROBABILITIES] = np.array([each.probability for each in self.alternatives])
        meta = {name: getattr(self, name) for name in ("mirror_check", "seed", "about")}
        meta |= {name: float(getattr(self, name)) for name in ("cost", "probability")}
        save_record(path, "Matching", arrays, meta | {"config": asdict(self.config)})

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Matching":
        """Read a file written by `save`, also by ``medialbench match`` and ``medialbench symmetry``.

        Raises
        ------
        InputError
            If the file is missing, cut short, or holds something else.
        """
        arrays, meta = _read(path)
        table = {
            name.removeprefix(_TABLE): arrays.pop(name) for name in list(arrays) if name.startswith(_TABLE)
        }
        if "flip" in meta:
            old = meta.pop("flip")
            meta["mirror_check"] = _OLD_WORDS.get(old, old)
        with unpacking(path, "Matching"):
            meta["config"].pop("first_mode", None)  # was always 1 unless someone changed it
            meta["config"] = MatchConfig.from_dict(meta["config"])
            meta["alternatives"] = _alternatives(arrays)
            _check(arrays, meta)
            return cls(**arrays, **meta, restarts=table)


def _read(path: str | os.PathLike[str]) -> tuple[dict[str, Any], dict[str, Any]]:
    """Arrays and metadata of a file; ``medialbench match`` once wrote a kind of its own, which held less."""
    try:
        return load_record(path, "Matching")
    except InputError as error:
        try:
            arrays, meta = load_record(path, "Correspondence")
        except InputError:
            raise error from None
    kept = {name: meta.pop(name) for name in ("cost", "flip", "seed") if name in meta}
    return arrays, kept | {"about": meta, "config": asdict(MatchConfig())}


def _check(arrays: dict[str, Any], meta: dict[str, Any]) -> None:
    """Raise ValueError unless the arrays of a file and its alternatives make a map."""
    clouds = {name: f"float {name[0]} 3" for name in _CLOUDS if name in arrays}
    layout = {"source_to_target": "int s", "landmarks": "int L 2", "confidence": "float s", **clouds}
    sizes = check_layout(arrays, layout)
    check_values(Matching, {name: meta[name] for name in ("mirror_check", "seed") if name in meta})
    count = sizes.get("t", np.iinfo(np.int64).max)
    for each in (arrays, *map(vars, meta["alternatives"])):
        check_layout(each, {"source_to_target": "int s", "confidence": "float s"}, finite="confidence")
        check_ids(each["source_to_target"], count, "a map", -1)
        if len(each["confidence"]) != sizes["s"] or np.abs(each["confidence"] - 0.5).max(initial=0) > 0.5:
            raise ValueError("a confidence is missing or outside [0, 1]")
    check_ids(arrays["landmarks"][:, 0], sizes["s"], "source landmarks")


def _alternatives(arrays: dict[str, Any]) -> tuple[Alternative, ...]:
    """Taken out of the arrays of a file."""
    if _OTHERS not in arrays:
        return ()
    columns = arrays.pop(_PROBABILITIES), arrays.pop(_OTHERS), arrays.pop(_OTHERS_CONFIDENCE)
    return tuple(
        Alternative(float(p), np.asarray(m, np.int64), np.asarray(c, np.float64))
        for p, m, c in zip(*columns, strict=True)
    )


_ARRAYS = ("source_to_target", "landmarks", "confidence")
_CLOUDS = ("source_points", "target_points")
_TABLE = "restarts_"
_OTHERS, _OTHERS_CONFIDENCE = "alternatives", "alternative_confidence"
_PROBABILITIES = "alternative_probabilities"
_OLD_WORDS = {"kept": "agrees", "flipped": "overruled"}
"""What files called the mirror check before it had its name."""
