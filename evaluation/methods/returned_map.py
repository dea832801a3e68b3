"""What a method returns, checked once: whatever passes can be stored, scored and drawn."""

import json
import math
import operator
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError
from medial.matching.config import MatchConfig
from medial.matching.result import Alternative, Matching

LONGEST_NAME = 60
"""Characters in the name of a column of `Matching.restarts`."""
MIRROR_CHECKS = ("agrees", "overruled", "undecided", "unchecked")
"""Words of `Matching.mirror_check`."""


def checked_map(found: object, n_source: int, n_target: int) -> Matching:
    """The map that a method returned, in the types of `medial.Matching`.

    Parameters
    ----------
    found
        What came back.
    n_source, n_target
        Points of the two clouds.

    Raises
    ------
    InputError
        If it is no `Matching`, or one of its fields has another shape, type or range than promised.
    """
    if not isinstance(found, Matching):
        raise InputError(
            f"the method returned {_kind(found)}, not a Matching; return dense(target_ids, confidence)"
        )
    if not isinstance(found.config, MatchConfig):
        raise InputError(f"config is {_kind(found.config)}, not a MatchConfig; leave it out")
    if found.mirror_check not in MIRROR_CHECKS:
        raise InputError(f"mirror_check is {found.mirror_check!r}; give one of {', '.join(MIRROR_CHECKS)}")
    return replace(
        found,
        source_to_target=_target_ids(found.source_to_target, "source_to_target", n_source, n_target),
        confidence=_shares(found.confidence, "confidence", n_source),
        landmarks=_landmarks(found.landmarks, n_source, n_target),
        cost=_number(found.cost, "cost"),
        probability=_probability(found.probability),
        seed=_whole(found.seed, "seed"),
        restarts=_restarts(found.restarts),
        source_points=_cloud(found.source_points, "source_points", n_source),
        target_points=_cloud(found.target_points, "target_points", n_target),
        about=_facts(found.about),
        alternatives=_alternatives(found.alternatives, n_source, n_target),
    )


def _target_ids(ids: Any, name: str, n_source: int, n_target: int) -> NDArray[np.int64]:
    array = _integers(ids, name, (n_source,))
    if n_source and not -1 <= array.min() <= array.max() < n_target:
        raise InputError(
            f"{name} holds target ids {array.min()} to {array.max()}, not in [-1, {n_target}); -1 is no match"
        )
    return array.astype(np.int64)


def _landmarks(pairs: Any, n_source: int, n_target: int) -> NDArray[np.int64]:
    count = len(pairs) if isinstance(pairs, np.ndarray) and pairs.ndim else 0
    array = _integers(pairs, "landmarks", (count, 2))
    for side, limit, ids in zip(("source", "target"), (n_source, n_target), array.T, strict=True):
        if count and not 0 <= ids.min() <= ids.max() < limit:
            raise InputError(
                f"landmarks hold {side} ids {ids.min()} to {ids.max()}, not in [0, {limit}); "
                "leave out landmarks without a match"
            )
    return array.astype(np.int64)


def _shares(values: Any, name: str, count: int) -> NDArray[np.float64]:
    array = _plain(values, name, (count,))
    if array.dtype.kind not in "fiub":
        raise InputError(f"{name} is of type {array.dtype}, not real numbers; give shares in [0, 1]")
    array = array.astype(np.float64)
    bad = ~((array >= 0) & (array <= 1))  # nan fails both
    if bad.any():
        raise InputError(
            f"{name} holds {array[bad][0]:g} at point {bad.argmax()} ({bad.sum()} of {count} points "
            "are not in [0, 1]); clip it"
        )
    return array


def _alternatives(given: Any, n_source: int, n_target: int) -> tuple[Alternative, ...]:
    if not isinstance(given, tuple | list) or not all(isinstance(each, Alternative) for each in given):
        raise InputError(f"alternatives are {_kind(given)}, not a tuple of Alternative; leave them out")
    return tuple(
        Alternative(
            float(_shares(np.atleast_1d(each.probability), f"{name} probability", 1)[0]),
            _target_ids(each.source_to_target, f"{name} source_to_target", n_source, n_target),
            _shares(each.confidence, f"{name} confidence", n_source),
        )
        for name, each in ((f"alternative {k}:", each) for k, each in enumerate(given))
    )


def _restarts(table: Any) -> dict[str, NDArray[Any]]:
    if not isinstance(table, dict):
        raise InputError(f"restarts are {_kind(table)}, not a dictionary of arrays; give {{}}")
    return {_restart_name(name): _restart_column(column, name) for name, column in table.items()}


def _restart_name(name: Any) -> str:
    """The name, which is part of the name of an array in a file."""
    if not (isinstance(name, str) and name.isidentifier() and len(name) <= LONGEST_NAME):
        raise InputError(
            f"restarts has a column {repr(name)[:80]}; give it a name of letters, digits and _, "
            f"at most {LONGEST_NAME}"
        )
    return name


def _restart_column(column: Any, name: str) -> NDArray[Any]:
    try:
        array = np.array(column)
    except (TypeError, ValueError):
        raise InputError(f"restarts[{name!r}] is no array of numbers; leave it out") from None
    if array.dtype.kind not in "biuf":
        raise InputError(f"restarts[{name!r}] is of type {array.dtype}, not numbers; leave it out")
    return array


def _cloud(points: Any, name: str, count: int) -> NDArray[np.float64] | None:
    if points is None:
        return None
    array = _plain(points, name, (count, 3))
    if array.dtype.kind not in "fiu":
        raise InputError(f"{name} is of type {array.dtype}, not real numbers; leave it out")
    return array.astype(np.float64)


def _facts(about: Any) -> dict[str, Any]:
    """The further facts, if JSON can hold them."""
    try:
        return dict(json.loads(json.dumps(about, default=lambda value: value.tolist())))
    except (TypeError, ValueError, AttributeError, RecursionError) as error:
        raise InputError(
            f"about cannot be stored as JSON ({error}); give a dictionary of plain values"
        ) from None


def _integers(values: Any, name: str, shape: tuple[int, ...]) -> NDArray[Any]:
    array = _plain(values, name, shape)
    if array.dtype.kind not in "iu" and array.size:
        raise InputError(f"{name} is of type {array.dtype}, not integer; round it yourself")
    return array


def _plain(values: Any, name: str, shape: tuple[int, ...]) -> NDArray[Any]:
    """The array itself, if it is one of this shape without a mask."""
    if not isinstance(values, np.ndarray):
        raise InputError(f"{name} is {_kind(values)}, not a NumPy array of shape {shape}")
    if isinstance(values, np.ma.MaskedArray):
        raise InputError(f"{name} is a masked array; fill it, with -1 for no match")
    if values.shape != shape:
        raise InputError(f"{name} has shape {values.shape}, not {shape}")
    return values


def _number(value: Any, name: str) -> float:
    """A finite number or nan."""
    try:
        number = float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{name} is {_kind(value)}, not a number that can be stored") from None
    if math.isinf(number):
        raise InputError(f"{name} is {number}; give a finite number, or nan if there is none")
    return number


def _probability(value: Any) -> float:
    number = _number(value, "probability")
    if not (math.isnan(number) or 0 <= number <= 1):
        raise InputError(f"probability is {number:g}, not in [0, 1]; leave it out if there is none")
    return number


def _whole(value: Any, name: str) -> int:
    try:
        return operator.index(value)
    except TypeError:
        raise InputError(
            f"{name} is {_kind(value)}, not an integer; pass on the one that was given"
        ) from None


def _kind(value: object) -> str:
    kind = type(value).__name__
    return "nothing" if value is None else f"{'an' if kind[:1].lower() in 'aeiou' else 'a'} {kind}"
