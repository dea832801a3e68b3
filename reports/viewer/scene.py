"""What a view shows: clouds, fields of numbers on them, and maps between them."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.typing import NDArray

Table = Literal["viridis", "error", "confidence"]


@dataclass(frozen=True)
class ViewField:
    """Numbers at the points of a cloud.

    Attributes
    ----------
    name, label : str
        For the program, and for readers.
    values : (n,) or (T, n) float64
        One number a point, or one for each of T frames.
    low, high : float
        Values at the ends of the colours.
    frames : tuple of str
        What each frame is, such as a time; empty without frames.
    table : str
        Colours.
    """

    name: str
    label: str
    values: NDArray[np.float64]
    low: float
    high: float
    frames: tuple[str, ...] = ()
    table: Table = "viridis"


@dataclass(frozen=True)
class ViewCloud:
    """A cloud.

    Attributes
    ----------
    name, caption : str
    points : (n, 3) float64
    normals : (n, 3) float64 or None
        Outward. What faces away is drawn as the inside.
    colors : (n, 3) float64 or None
        In [0, 1], by place on the body: what the map carries from the source.
    color_label : str
        What those colours are.
    centers : (n, 3) float64 or None
        Medial centres (Eq. 9).
    fields : tuple of ViewField
    """

    name: str
    points: NDArray[np.float64]
    normals: NDArray[np.float64] | None = None
    caption: str = ""
    colors: NDArray[np.float64] | None = None
    color_label: str = ""
    centers: NDArray[np.float64] | None = None
    fields: tuple[ViewField, ...] = ()


@dataclass(frozen=True)
class ViewMap:
    """A map from the first cloud to another, or to itself.

    Attributes
    ----------
    label, note : str
    image : (n_source,) integer
        Point of the target; -1 for none.
    target : int
        Number of the target cloud.
    confidence : (n_source,) float64 or None
        In [0, 1].
    errors : (n_source,) float64 or None
        x 100 / sqrt(area); nan where unknown.
    landmarks : (L, 2) integer
    """

    label: str
    image: NDArray[np.integer]
    target: int = 1
    note: str = ""
    confidence: NDArray[np.float64] | None = None
    errors: NDArray[np.float64] | None = None
    landmarks: NDArray[np.integer] = field(default_factory=lambda: np.empty((0, 2), dtype=np.int64))


@dataclass(frozen=True)
class Scene:
    """All that one view shows.

    Attributes
    ----------
    title : str
    clouds : tuple of ViewCloud
        The source first.
    maps : tuple of ViewMap
        None for a cloud alone.
    up : int
        Axis that points up: 0, 1 or 2.
    truth : (n_source,) integer or None
        Target point nearest to the true place of each source point; -1 where none is near.
    error_top : float
        Error at the end of the fixed scale of colours.
    threshold_on : str
        Name of a field whose smaller values a slider hides; empty for none.
    """

    title: str
    clouds: tuple[ViewCloud, ...]
    maps: tuple[ViewMap, ...] = ()
    up: int = 1
    truth: NDArray[np.integer] | None = None
    error_top: float = 10.0
    threshold_on: str = ""

    def field_of(self, name: str) -> ViewField:
        """A field of the first cloud by its name; KeyError if there is none."""
        fields: Mapping[str, ViewField] = {each.name: each for each in self.clouds[0].fields}
        return fields[name]
