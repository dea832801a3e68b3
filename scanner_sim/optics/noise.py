"""Random numbers that belong to a sample: the same whatever else is measured, and in which order.

A sample is one pixel under one stripe of one view. Its random numbers are a hash of that identity and the
seed, so that a pixel more or less, as between two Mitsuba variants, leaves the noise of all others as it is.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.special import ndtri

_GOLDEN = np.uint64(0x9E3779B97F4A7C15)
_MIX = (np.uint64(0xBF58476D1CE4E5B9), np.uint64(0x94D049BB133111EB))


def mixed(values: NDArray[np.uint64]) -> NDArray[np.uint64]:
    """Scramble 64-bit integers: the finaliser of splitmix64 [Steele et al. 2014]."""
    values = (values ^ (values >> np.uint64(30))) * _MIX[0]
    values = (values ^ (values >> np.uint64(27))) * _MIX[1]
    return values ^ (values >> np.uint64(31))


@dataclass(frozen=True)
class SampleNoise:
    """Noise of the samples of some pixels of a view.

    Attributes
    ----------
    seed, view : int
    pixels : (n, 2) int32
        Column and row.
    first : (n,) int64
        Number of the first stripe of each pixel's row of samples.
    width : int
        Samples w in a row.
    """

    seed: int
    view: int
    pixels: NDArray[np.int32]
    first: NDArray[np.int64]
    width: int

    def uniform(self, stream: int) -> NDArray[np.float64]:
        """Numbers uniform in (0, 1), (n, w); another set for each stream."""
        key = np.random.SeedSequence([self.seed, self.view, stream]).generate_state(2, np.uint64)
        column, row = self.pixels.astype(np.uint64).T
        pixel = mixed((row << np.uint64(32) | column) + key[0])
        stripe = (self.first[:, None] + np.arange(self.width)).astype(np.uint64)
        bits = mixed(mixed(pixel[:, None] + stripe * _GOLDEN) + key[1])
        return ((bits >> np.uint64(12)).astype(np.float64) + 0.5) * 2.0**-52

    def normal(self, stream: int) -> NDArray[np.float64]:
        """Standard normal numbers, (n, w); another set for each stream."""
        return np.asarray(ndtri(self.uniform(stream)))
