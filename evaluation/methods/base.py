"""The one interface of all methods: two clouds in, a map with confidence out."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError
from evaluation.experiment.toml_tables import dataclass_from_table
from medial.diffusion import Diffusion
from medial.matching.result import Matching
from scanner_sim.scan import Scan


@dataclass(frozen=True)
class MethodInput:
    """What a method may know of one side of a pair.

    In a sweep, every array is a read-only copy: copy what you change.

    Attributes
    ----------
    name : str
        Key of the scan in the results folder: no two clouds share it.
    scan : Scan
        Points, normals, views. Its ground truth (``face_ids``, ``barycentrics``, ``true_points``) is for
        scoring: a method that looks at it sets `Method.uses_truth`.
    operators : Mapping
        Diffusions by name, for the names in `Method.operators`.
    truth : (n, 3) float64 or None
        The points on the rest pose; given only to methods that declare `Method.uses_truth`.
    """

    name: str
    scan: Scan
    operators: Mapping[str, Diffusion] = field(default_factory=dict)
    truth: NDArray[np.float64] | None = None

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.scan)

    @property
    def points(self) -> NDArray[np.float64]:
        """(n, 3)."""
        return self.scan.points

    @property
    def normals(self) -> NDArray[np.float64]:
        """(n, 3), outward."""
        return self.scan.normals


@dataclass(frozen=True, kw_only=True)
class Method:
    """Base class; the fields of a subclass are its options, settable from TOML.

    Subclasses set what they need (`operators`, `requires`, `uses_truth`) and implement `match`.
    Everything random draws from the seed.
    """

    requires: ClassVar[Mapping[str, str]] = {}
    """Optional packages: import name to the argument of ``pip install``."""
    uses_truth: ClassVar[bool] = False
    """Whether it looks at the ground truth (ceilings do)."""

    @property
    def operators(self) -> tuple[str, ...]:
        """Operators it needs on both clouds: ``"medial"``, ``"heat"``, ``"robust"``; shared."""
        return ()

    @classmethod
    def from_options(cls, options: Mapping[str, Any]) -> "Method":
        """The method with options as read from a file.

        Raises
        ------
        InputError
            If an option is unknown or refused.
        """
        return dataclass_from_table(cls, dict(options), f"method {cls.__name__}")

    def match(self, source: MethodInput, target: MethodInput, seed: int) -> Matching:
        """Find the target point of every source point.

        Returns
        -------
        Matching
            With ``source_to_target`` in [-1, n_target), -1 for no match, and ``confidence`` in [0, 1].
        """
        raise NotImplementedError(f"{type(self).__name__} does not implement match")

    def fingerprint(self) -> str:
        """Hash of files that decide the result besides code and options; empty if there are none."""
        return ""


def require(count: int, least: int, method: str) -> None:
    """Raise unless there is enough of something for a method.

    Raises
    ------
    InputError
        If there is not.
    """
    if count < least:
        raise InputError(f"{method} needs at least {least} points, got {count}; scan or keep more")


def dense(
    source_to_target: NDArray[np.integer],
    confidence: NDArray[np.floating],
    *,
    landmarks: NDArray[np.integer] | None = None,
    cost: float = 0.0,
    seed: int = 0,
) -> Matching:
    """A `Matching` from a map alone, for methods without landmarks or restarts.

    Confidences are clipped to [0, 1]; everything else is checked where a method returns it
    (`evaluation.methods.returned_map`).

    Raises
    ------
    InputError
        If the two arrays differ in length, ids are no integers, confidences no numbers, or one has a mask.
    """
    image = _array(source_to_target, "target ids", "iu")
    pairs = np.zeros((0, 2), np.int64) if landmarks is None else _array(landmarks, "landmarks", "iu")
    shares = _array(confidence, "confidences", "fiub")
    if image.shape[:1] != shares.shape[:1] or image.ndim != 1:
        raise InputError(
            f"target ids of shape {image.shape} with confidences of shape {shares.shape}; give one of each "
            "for every source point"
        )
    return Matching(
        source_to_target=image.astype(np.int64),
        landmarks=pairs.astype(np.int64),
        cost=float(cost),
        confidence=np.clip(shares.astype(np.float64), 0, 1),
        restarts={},
        seed=seed,
    )


def _array(values: Any, name: str, kinds: str) -> NDArray[Any]:
    """An array of numbers of some kinds (`numpy.dtype.kind`), without a mask."""
    try:
        array = np.asarray(values)
    except (TypeError, ValueError):
        raise InputError(f"{name} are a {type(values).__name__}, no array; give one") from None
    if isinstance(values, np.ma.MaskedArray):
        raise InputError(f"{name} are a masked array; fill it, ids with -1 for no match")
    if array.size and array.dtype.kind not in kinds:
        wanted = "integer; round them yourself" if kinds == "iu" else "numbers; give shares in [0, 1]"
        raise InputError(f"{name} are of type {array.dtype}, not {wanted}")
    return array
