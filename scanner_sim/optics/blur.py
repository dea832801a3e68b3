"""Blur of each stripe's image over pixels: every pixel gathers the light of its neighbours."""

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import correlate1d, maximum_filter, minimum_filter

from scanner_sim.optics.rows import Rows
from scanner_sim.scanner_config import ScannerConfig

CHUNK = 16
"""Stripes whose images are blurred together."""


def kernel(deviation: float) -> NDArray[np.float64]:
    """Gaussian weights of a standard deviation in pixels, (2 r + 1,), cut where they fall below .5 %.

    The reference's laser smoother s has ``exp(-2 x^2 / s^2)``: a standard deviation of s / 2, cut at the
    same height but never below 2 pixels.
    """
    reach = max(2, int(np.ceil(np.sqrt(-2 * np.log(0.005)) * deviation)))
    weights = np.exp(-0.5 * (np.arange(-reach, reach + 1) / deviation) ** 2)
    return np.asarray(weights / weights.sum())


def blurred(pixels: NDArray[np.int32], rows: Rows, config: ScannerConfig) -> Rows:
    """Rows after the image of every stripe was blurred by a separable Gaussian.

    Parameters
    ----------
    pixels : (n, 2)
        Of the rows; each at most once. Other pixels are dark.
    rows
    config

    Returns
    -------
    Rows
        Of the same pixels, longer by the stripes that light their neighbours.
    """
    weights = kernel(config.smoothing)
    reach = len(weights) // 2
    wide = Rows(*_reached(pixels, rows, reach, config), np.empty(0))
    row, stripe = rows.stripes()
    source = _Samples(pixels[row], stripe, rows.values, rows.values > 0)
    out_row, out_stripe = Rows(wide.first, wide.stop, np.empty(int((wide.stop - wide.first).sum()))).stripes()
    target = _Samples(pixels[out_row], out_stripe, np.zeros(len(out_row)), np.ones(len(out_row), bool))
    for chunk in np.unique(source.stripe // CHUNK):
        given, wanted = source.of(chunk), target.of(chunk)
        if len(given) == 0 or len(wanted) == 0:
            continue
        corner = source.pixels[given].min(axis=0) - reach
        size = source.pixels[given].max(axis=0) + reach + 1 - corner
        images = np.zeros((size[1], size[0], CHUNK))
        x, y = (source.pixels[given] - corner).T
        images[y, x, source.stripe[given] - chunk * CHUNK] = source.values[given]
        for axis in (0, 1):
            images = correlate1d(images, weights, axis=axis, mode="constant")
        place = target.pixels[wanted] - corner
        seen = ((place >= 0) & (place < size)).all(axis=1)
        x, y = place[seen].T
        target.values[wanted[seen]] = images[y, x, target.stripe[wanted[seen]] - chunk * CHUNK]
    return Rows(wide.first, wide.stop, target.values)


class _Samples:
    """Samples (s,) of pixels (s, 2), found by the chunk of their stripe."""

    def __init__(
        self,
        pixels: NDArray[np.int32],
        stripe: NDArray[np.int64],
        values: NDArray[np.float64],
        used: NDArray[np.bool_],
    ) -> None:
        self.pixels, self.stripe, self.values = pixels, stripe, values
        used_index = np.flatnonzero(used)
        self._order = used_index[np.argsort(stripe[used_index] // CHUNK, kind="stable")]
        self._chunk = stripe[self._order] // CHUNK

    def of(self, chunk: int) -> NDArray[np.int64]:
        """Indices of the samples under the stripes of a chunk."""
        low, high = np.searchsorted(self._chunk, [chunk, chunk + 1])
        return self._order[low:high]


def _reached(
    pixels: NDArray[np.int32], rows: Rows, reach: int, config: ScannerConfig
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """First stripe and the one after the last that light a pixel or a neighbour within reach, (n,) each."""
    columns, lines = config.resolution
    first = np.full((lines, columns), config.stripes, np.int64)
    stop = np.zeros((lines, columns), np.int64)
    first[pixels[:, 1], pixels[:, 0]] = np.clip(rows.first, 0, config.stripes)
    stop[pixels[:, 1], pixels[:, 0]] = np.clip(rows.stop, 0, config.stripes)
    size = 2 * reach + 1
    low = minimum_filter(first, size, mode="constant", cval=config.stripes)[pixels[:, 1], pixels[:, 0]]
    high = maximum_filter(stop, size, mode="constant", cval=0)[pixels[:, 1], pixels[:, 0]]
    return low, np.maximum(high, low)
