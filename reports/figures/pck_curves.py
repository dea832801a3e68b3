"""Share of points matched within a radius: the PCK curves of [KLF11], a line per method."""

from collections.abc import Mapping

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from reports.figures.style import as_label, legend_below, method_lines, new_figure, styled
from reports.method_order import order_methods

TICKS = (0.5, 1, 2, 5, 10, 25)


@styled
def pck_curves(curves: Mapping[str, Mapping[str, NDArray[np.float64]]], radii: NDArray[np.float64]) -> Figure:
    """Share of points matched within a radius, a panel per group and a line per method.

    Parameters
    ----------
    curves
        ``curves[group][method]`` is (r,), the share of points in [0, 1] at each radius.
    radii : (r,)
        Geodesic error x100 / sqrt(area), ascending. The axis is logarithmic, because good methods differ at
        small radii alone; a radius of 0 is left out.
    """
    columns = min(4, len(curves))
    rows = -(-len(curves) // columns)
    figure, grid = new_figure(rows, columns, 2.45 * columns + 0.6, 2.2 * rows + 0.5, sharex=True, sharey=True)
    methods = order_methods(name for group in curves.values() for name in group)
    styles = method_lines(methods)
    for axes, (group, lines) in zip(grid.flat, curves.items(), strict=False):
        for name in methods:
            if name in lines:
                axes.plot(radii, 100 * lines[name], **styles[name], label=as_label(name))
        axes.set_title(group)
        axes.set_ylim(0, 100)
        axes.set_xscale("log")
        axes.set_xlim(radii[radii > 0][0], radii[-1])
        ticks = [value for value in TICKS if radii[radii > 0][0] <= value <= radii[-1]]
        axes.set_xticks(ticks, [f"{value:g}" for value in ticks])
        axes.minorticks_off()
    for number, axes in enumerate(grid.flat):
        axes.set_visible(number < len(curves))
        if number + columns >= len(curves):
            axes.set_xlabel("error × 100 / √area")
            axes.tick_params(labelbottom=True)
    for row in grid:
        row[0].set_ylabel("points matched within, %")
    handles = {line.get_label(): line for axes in grid.flat for line in axes.get_lines()}
    labels = [as_label(name) for name in methods]
    legend_below(figure, [handles[label] for label in labels], labels)
    return figure
