"""What goes into a stage and what comes out."""

import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any


@dataclass(frozen=True)
class Output:
    """The result of a stage.

    Attributes
    ----------
    save : callable or None
        Writes the record to a path; None if `info` is all there is.
    info : Mapping
        Small facts that JSON can hold.
    """

    save: Callable[[str | os.PathLike[str]], None] | None
    info: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Inputs:
    """Stored results that a stage needs, by role; loaded when asked for.

    Attributes
    ----------
    keys : Mapping
        Keys by role.
    load : callable
        Role to record.
    note : callable
        Role to what is noted of the result (its `Output.info`).
    derive : callable
        Role and a function of its record to the function's value, kept for the tasks that follow.
    """

    keys: Mapping[str, str]
    load: Callable[[str], Any]
    note: Callable[[str], Mapping[str, Any]]
    derive: Callable[[str, Callable[[Any], Any]], Any]
