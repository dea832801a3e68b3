"""Means and intervals of errors that are nested: seeds within regimes, regimes within pairs of poses.

Maps of one pair of poses under other thresholds, views or seeds show the same two surfaces, so they are no
independent evidence. The pair of poses is the unit; its regimes and their seeds are resampled within it.

[Davison and Hinkley 1997] "Bootstrap Methods and their Application", Sec. 3.8 (hierarchical data).
[Hesterberg 2015] "What Teachers Should Know About the Bootstrap", The American Statistician 69 (4).
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.stats import t

DRAWS = 2000
LEVEL = 0.95

Float = NDArray[np.float64]


def nested_weights(cells: pd.DataFrame) -> Float:
    """Weight of each cell in the mean over units of means over parts, of means over the parts of these.

    Parameters
    ----------
    cells : (c, levels)
        One row per value, the outermost level in the first column.

    Returns
    -------
    (c,)
        They sum to 1.
    """
    weights = np.ones(len(cells))
    keys: list[str] = []
    for level in cells.columns:
        within = (
            cells.groupby(keys, sort=False)[level].transform("nunique") if keys else cells[level].nunique()
        )
        weights /= np.asarray(within, dtype=np.float64)
        keys.append(level)
    return weights / np.asarray(cells.groupby(keys, sort=False)[keys[-1]].transform("size"), dtype=np.float64)


def resampled_weights(cells: pd.DataFrame, draws: int = DRAWS, seed: int = 0) -> Float:
    """The same weights for resamples: units with replacement, in each its parts, in each of these theirs.

    Parameters
    ----------
    cells : (c, levels)
        As for `nested_weights`.
    draws, seed

    Returns
    -------
    (draws, c)
        Rows sum to 1.
    """
    rng = np.random.default_rng(seed)
    weights = np.zeros((draws, len(cells)))
    rows = pd.Series(np.arange(len(cells)), index=pd.MultiIndex.from_frame(cells))
    _share_out(weights, rows, list(cells.columns), np.ones(draws, dtype=np.int64), 1.0, rng)
    return weights


def _share_out(
    weights: Float,
    rows: "pd.Series[int]",
    levels: Sequence[str],
    copies: NDArray[np.int64],
    worth: float,
    rng: np.random.Generator,
) -> None:
    """Share `copies` of one part, each worth `worth`, out among what is in it."""
    if not levels:
        weights[:, rows.to_numpy()] += (copies * worth / len(rows))[:, None]
        return
    parts = [part for _, part in rows.groupby(level=levels[0], sort=False)]
    counts = rng.multinomial(copies * len(parts), np.full(len(parts), 1 / len(parts)))
    for part, count in zip(parts, counts.T, strict=True):
        _share_out(weights, part, levels[1:], count, worth / len(parts), rng)


def bootstrap_interval(
    mean: float, resampled: Float, units: int, level: float = LEVEL
) -> tuple[float, float]:
    """Interval of a mean from the spread of its resamples, widened for few units.

    The standard error of the resamples takes the place of s / sqrt(n) in Student's interval, times
    sqrt(n / (n - 1)), since resamples of n units spread too little by that [Hesterberg 2015, Sec. 5.2].
    Percentiles of the resamples would be as narrow as the units themselves where there are few.

    Parameters
    ----------
    mean
    resampled : (draws,)
        The mean of each resample.
    units
        Independent units behind it, n.
    level

    Returns
    -------
    low, high : float
        nan for fewer than two units.
    """
    if units < 2:
        return float("nan"), float("nan")
    reach = float(t.ppf((1 + level) / 2, units - 1) * resampled.std() * np.sqrt(units / (units - 1)))
    return mean - reach, mean + reach
