"""One look for all figures: colours that everyone can tell apart, few lines, units on every axis."""

import io
import itertools
import os
import warnings
from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from functools import wraps
from pathlib import Path
from typing import Any, ParamSpec, TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.layout_engine import ConstrainedLayoutEngine
from matplotlib.ticker import FuncFormatter, MaxNLocator, NullFormatter

from datasets_gen.records import atomic_path
from reports.method_order import METHODS, known_method, order_methods

P = ParamSpec("P")
T = TypeVar("T")

HEADROOM = 0.16
"""Inches above the heads of pictures, for which the layout leaves no room: captions, second lines."""
DPI = 160
NOTEBOOK_DPI = 110

INK = "#24292f"
QUIET = "#6e7781"
GRID = "#e3e6e9"
ABSENT = "#d9dcdf"
"""Points that a map says nothing about."""

CLOUD_INCHES = 2.5
"""Height of the tallest cloud of a figure that fits its clouds to their places."""
CLAY = "#9fb8d0"
"""Of clouds that show no values."""

_SPARE = ["#882255", "#44aa99", "#ddcc77", "#332288", "#999933", "#aa4499", "#117733", "#661100"]
_MARKERS = "osD^vP<>X*"
_DASHES = ["-", "--", ":", "-."]
USUAL_ROWS, ENTRY_HEIGHT = 3, 0.17
"""Rows of a legend for which figures have room, and the height of a further one, inches."""
_SETTINGS: Any = {
    "font.family": "DejaVu Sans",
    "font.size": 8.5,
    "axes.titlesize": 9.5,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.labelsize": 8.5,
    "axes.edgecolor": QUIET,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.linewidth": 0.8,
    "axes.grid": True,
    "axes.axisbelow": True,
    "grid.color": GRID,
    "grid.linewidth": 0.7,
    "text.color": INK,
    "xtick.color": QUIET,
    "ytick.color": QUIET,
    "xtick.labelcolor": INK,
    "ytick.labelcolor": INK,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "legend.fontsize": 8,
    "legend.frameon": False,
    "lines.linewidth": 1.6,
    "lines.markersize": 4.5,
    "pdf.fonttype": 42,
    "svg.hashsalt": "medialbench",
    "text.parse_math": False,  # names are shown as they are, also with dollar signs
}


def styled(draw: Callable[P, T]) -> Callable[P, T]:
    """Decorate a function that draws: it sees the house style, its caller's is left alone."""

    @wraps(draw)
    def wrapper(*args: P.args, **kwargs: P.kwargs) -> T:
        with mpl.rc_context(_SETTINGS):
            return draw(*args, **kwargs)

    return wrapper


class NotebookFigure(Figure):
    """A figure that a notebook shows without pyplot."""

    def _repr_png_(self) -> bytes:
        """Return the picture that a notebook shows."""
        stream = io.BytesIO()
        with mpl.rc_context(_SETTINGS):
            self.savefig(stream, format="png", dpi=NOTEBOOK_DPI)
        return stream.getvalue()


def new_figure(
    rows: int, columns: int, width: float, height: float, headroom: float = 0.0, **options: Any
) -> tuple[Figure, np.ndarray]:
    """Figure and its (rows, columns) axes; sizes in inches. Call it from a `styled` function."""
    layout = ConstrainedLayoutEngine(rect=(0, 0, 1, 1 - headroom / height))
    figure = NotebookFigure(figsize=(width, height), dpi=DPI, layout=layout)
    FigureCanvasAgg(figure)
    return figure, figure.subplots(rows, columns, squeeze=False, **options)


_OPTIONS: dict[str, dict[str, Any]] = {
    ".png": {"pil_kwargs": {"compress_level": 4}},
    ".pdf": {"metadata": {"CreationDate": None, "Producer": None}},
}


def save(
    figure: Figure,
    folder: str | os.PathLike[str],
    name: str,
    formats: Sequence[str] = (".png", ".pdf"),
    dpi: int = DPI,
) -> list[Path]:
    """Write a figure into a folder, a file per format; return their paths.

    The files are the same for the same figure: no dates are written.
    """
    with mpl.rc_context(_SETTINGS), warnings.catch_warnings():
        warnings.filterwarnings("ignore", r"Glyph \d+", UserWarning)  # an emoji in a name is drawn as a box
        for suffix in formats:
            with atomic_path(Path(folder) / (name + suffix)) as temporary:
                figure.savefig(temporary, dpi=dpi, **_OPTIONS[suffix])
            figure.set_layout_engine("none")  # both formats share one layout, which is slow to find
    return [Path(folder) / (name + suffix) for suffix in formats]


def method_colors(methods: Iterable[str]) -> dict[str, str]:
    """Colour of each label: of the known method it begins with; a spare one if that is taken or unknown."""
    labels = order_methods(methods)
    colors: dict[str, str] = {}
    spare = itertools.cycle(_SPARE)
    for label in labels:
        known = METHODS.get(known_method(label), "")
        colors[label] = known if known and known not in colors.values() else next(spare)
    return colors


def method_lines(methods: Iterable[str]) -> dict[str, dict[str, Any]]:
    """Colour and dashes of each label's line: those of one colour differ in their dashes."""
    colors = method_colors(methods)
    used: Counter[str] = Counter()
    lines: dict[str, dict[str, Any]] = {}
    for label, color in colors.items():
        lines[label] = {"color": color, "linestyle": _DASHES[used[color] % len(_DASHES)]}
        used[color] += 1
    return lines


def as_label(name: str) -> str:
    """A name for a legend, which leaves out what begins with an underscore."""
    return f"\u200b{name}" if name.startswith("_") else name


def series_styles(names: Sequence[str]) -> dict[str, dict[str, Any]]:
    """Line colour and marker of each of several ordered series, such as poses."""
    colors = list(dict.fromkeys([*METHODS.values(), *_SPARE]))
    return {
        name: {"color": colors[i % len(colors)], "marker": _MARKERS[i % len(_MARKERS)]}
        for i, name in enumerate(names)
    }


def legend_below(figure: Figure, handles: Sequence[Any], labels: Sequence[str], title: str = "") -> None:
    """A legend under all panels, in as many columns as fit the width; a long one makes the figure higher."""
    inches = 0.065 * max(map(len, labels), default=0) + 0.55  # of an entry: letters, line, gap
    columns = min(max(int(figure.get_figwidth() / inches), 1), len(labels) or 1)
    rows = -(-len(labels) // columns)
    figure.set_figheight(figure.get_figheight() + ENTRY_HEIGHT * max(rows - USUAL_ROWS, 0))
    figure.legend(handles, labels, loc="outside lower center", ncols=columns, title=title or None)


def plain_numbers(axis: Axis) -> None:
    """Write the ticks of a logarithmic axis as plain numbers: mathematical text is off.

    An axis of less than a decade has ticks at even distances, as it may have no power of ten.
    """
    low, high = axis.get_view_interval()
    if high < 10 * low:
        axis.set_major_locator(MaxNLocator(4))
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


def blank(axes: Axes) -> None:
    """Turn an axes into a bare canvas for a picture."""
    axes.set_axis_off()
    axes.set_aspect("equal", anchor="N")  # the head stays at the edge that the layout keeps room for
