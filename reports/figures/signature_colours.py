"""The signature m_t(x, x) in colours, on one scale for all clouds that are compared."""

from collections.abc import Sequence

import matplotlib as mpl
import numpy as np
from matplotlib.colors import Colormap, LogNorm
from numpy.typing import NDArray

from medial import Diffusion

SIGNATURE: Colormap = mpl.colormaps["viridis"]
"""Dark where heat has spread, light where it stays."""
LABEL = "area · m_t(x, x)"
QUANTILES = (0.01, 0.99)


def signatures(diffusion: Diffusion, times: NDArray[np.float64], area: float) -> NDArray[np.float64]:
    """m_t(x, x) of every point and time, times the area of the body at rest: without unit, (n, T)."""
    return area * diffusion.signature(times)


def shared_norm(values: Sequence[NDArray[np.float64]]) -> LogNorm:
    """A logarithmic scale that holds the values of several clouds but for the extremes."""
    low, high = np.quantile(np.concatenate([np.ravel(each) for each in values]), QUANTILES)
    low = max(float(low), 1e-12)
    return LogNorm(low, max(float(high), 1.001 * low), clip=True)


def signature_colors(values: NDArray[np.float64], norm: LogNorm) -> NDArray[np.float64]:
    """Colours of values, (n, 3)."""
    return np.asarray(SIGNATURE(norm(np.maximum(values, 1e-300)))[:, :3])


def few_ticks(norm: LogNorm) -> list[float]:
    """Two to four round numbers within a logarithmic scale."""
    low, high = float(norm.vmin or 0), float(norm.vmax or 0)
    decades = range(int(np.floor(np.log10(low))), int(np.ceil(np.log10(high))) + 1)
    for steps in ((1.0,), (1.0, 3.0), (1.0, 2.0, 5.0), (1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0)):
        ticks = [step * 10.0**k for k in decades for step in steps if low <= step * 10.0**k <= high]
        if len(ticks) >= 2:
            return ticks if len(ticks) <= 4 else ticks[:: -(-len(ticks) // 4)]
    return [float(f"{low:.3g}"), float(f"{high:.3g}")]
