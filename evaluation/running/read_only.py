"""Values that several tasks of a worker share: nobody can write into them."""

import copy
from collections.abc import Mapping
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
    found: T = _locked(value)
    return found


def _locked(value: Any) -> Any:
    if isinstance(value, np.ndarray):
        return _array(value)
    if isinstance(value, Mapping):
        return {key: _locked(each) for key, each in value.items()}
    if isinstance(value, list | tuple):
        parts = [_locked(each) for each in value]
        return type(value)(*parts) if hasattr(value, "_fields") else type(value)(parts)
    if is_dataclass(value) and not isinstance(value, type):
        return _record(value)
    if issparse(value) or type(value).__module__.partition(".")[0] in PACKAGES:
        for name, each in vars(value).items():
            object.__setattr__(value, name, _locked(each))
    return value


def _array(array: NDArray[Any]) -> NDArray[Any]:
    base: Any = array
    while isinstance(base, np.ndarray):
        base.setflags(write=False)
        base = base.base
    return array.view()


def _record(record: Any) -> Any:
    """A copy of a dataclass, frozen or not, with what it has computed for itself so far."""
    found = copy.copy(record)
    names = vars(record) if hasattr(record, "__dict__") else [each.name for each in fields(record)]
    for name in list(names):
        object.__setattr__(found, name, _locked(getattr(record, name)))
    return found
