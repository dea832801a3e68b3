"""Values that several tasks of a worker share: nobody can write into them."""

import copy
from collections.abc import Callable, Mapping
from dataclasses import fields, is_dataclass
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import issparse

T = TypeVar("T")

PACKAGES = ("datasets_gen", "scanner_sim", "medial", "evaluation")
"""Where the classes live whose objects are looked into; what a library keeps inside is its own."""


def read_only(value: T) -> T:
    """The value with every array in it made read-only, however deep.

    Arrays are locked in place and given as views, which cannot be unlocked. Dataclasses, mappings and
    sequences are copied, so that a new entry of a dictionary stays with whoever made it; their arrays are not
    copied. Other objects of this project are locked in place.

    Parameters
    ----------
    value
        A record such as a `scanner_sim.Scan`, or anything made of such.
    """
    found: T = _through(value, _locked)
    return found


def private(value: T) -> T:
    """A copy of the value that shares no memory with it, its arrays read-only, however deep.

    A view can be written into by way of the array that it is a view of, and by code in other languages, which
    knows no locks. Whoever does so with this copy spoils nothing of others.

    Parameters
    ----------
    value
        As for `read_only`. What its records have computed for themselves stays behind.
    """
    found: T = _through(value, _copied, fields_alone=True)
    return found


def _through(value: Any, change: Callable[[NDArray[Any]], NDArray[Any]], fields_alone: bool = False) -> Any:
    """The value with each array in it changed."""
    if isinstance(value, np.ndarray):
        return change(value)
    if isinstance(value, Mapping):
        return {key: _through(each, change, fields_alone) for key, each in value.items()}
    if isinstance(value, list | tuple):
        parts = [_through(each, change, fields_alone) for each in value]
        return type(value)(*parts) if hasattr(value, "_fields") else type(value)(parts)
    if is_dataclass(value) and not isinstance(value, type):
        return _record(value, change, fields_alone)
    if issparse(value) or type(value).__module__.partition(".")[0] in PACKAGES:
        found = copy.copy(value) if fields_alone else value
        for name, each in vars(value).items():
            object.__setattr__(found, name, _through(each, change, fields_alone))
        return found
    return value


def _copied(array: NDArray[Any]) -> NDArray[Any]:
    return _locked(array.copy(order="K"))


def _locked(array: NDArray[Any]) -> NDArray[Any]:
    base: Any = array
    while isinstance(base, np.ndarray):
        base.setflags(write=False)
        base = base.base
    return array.view()


def _record(record: Any, change: Callable[[NDArray[Any]], NDArray[Any]], fields_alone: bool) -> Any:
    """A copy of a dataclass, frozen or not; unless `fields_alone`, with what it has computed for itself."""
    found, names = copy.copy(record), [each.name for each in fields(record)]
    if hasattr(record, "__dict__"):
        computed = [name for name in vars(record) if name not in names]
        for name in computed if fields_alone else ():
            del vars(found)[name]
        names += () if fields_alone else computed
    for name in names:
        object.__setattr__(found, name, _through(getattr(record, name), change, fields_alone))
    return found
