r"""Multiplicative laser speckle: what a rough surface does to coherent light on the sensor.

A fully developed speckle pattern is the intensity :math:`|a|^2` of a circular complex Gaussian field a; it is
exponentially distributed, so its contrast (standard deviation over mean) is 1. Light that is the sum of
several independent patterns has less [Goo07, Sec. 3.2]. Here a is white noise, filtered so that the
autocovariance of the intensity is ``exp(-(d / size)^2)`` at a distance of d pixels.

The patterns of two stripes are independent. On the surface this asks for a sheet that moves by more than a
grain, or turns by more than the wavelength over the width of the sheet, from one stripe to the next.

Noise is a hash of pixel, stripe and seed, so a factor does not depend on which other pixels are measured. The
570,000 samples of a view of 400 x 400 pixels take 0.2 s at a contrast of 1, 0.6 s at one of 0.5, where four
patterns are added up, and 0.15 s below 0.25.

References
----------
[Goo07] J. W. Goodman, *Speckle Phenomena in Optics: Theory and Applications*, Roberts, 2007.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled, ranges, run_tasks
from scanner_sim.optics.noise import SampleNoise, mixed

FIRST_STREAM = 16
"""Of `SampleNoise`: the white noise of the first pattern; the others follow."""
MOST_PATTERNS = 16
"""Where more would have to be added up, the distribution of their sum is taken instead."""
REACH = 2.5
"""Filters are cut at this many widths, 3.5 of their own standard deviations."""
_STRIPES_AT_ONCE = 16

_mixed = compiled()(mixed)


def factors(noise: SampleNoise, contrast: float, size: float) -> NDArray[np.float64]:
    """Factors of the laser's light, with mean 1.

    Parameters
    ----------
    noise
        Pixels, their rows of samples, and seed.
    contrast
        Standard deviation C of the factors, in (0, 1].
    size
        Distance at which the autocovariance of the factors has fallen to 1/e, pixels.

    Returns
    -------
    (n, w) float64
        Not negative.
    """
    samples = _Samples.of(noise)
    if contrast**-2 > MOST_PATTERNS:
        # a real field's own correlation is that of the factors; a complex one's is its square root
        return gamma_factors(samples.field(noise, 0, size / math.sqrt(2)).real, contrast)
    total = np.zeros(samples.shape)
    for pattern, weight in enumerate(pattern_weights(contrast)):
        field = samples.field(noise, pattern, size)
        total += weight / 2 * (field.real**2 + field.imag**2)
    return total


def pattern_weights(contrast: float) -> list[float]:
    """Weights of independent fully developed patterns whose sum has mean 1 and a contrast of C exactly.

    The least number of patterns, M = ceil(1 / C^2): M - 1 of equal weight and one lighter, so that the
    weights sum to 1 and their squares to C^2 [Goo07, Sec. 3.2].
    """
    count = max(math.ceil(contrast**-2 - 1e-9), 1)
    if count == 1:
        return [1.0]
    last = (1 - math.sqrt(max((count - 1) * (count * contrast**2 - 1), 0))) / count
    return [(1 - last) / (count - 1)] * (count - 1) + [last]


def gamma_factors(normal: NDArray[np.floating], contrast: float) -> NDArray[np.float64]:
    """Gamma distributed factors of mean 1 and contrast C from standard normal numbers of the same shape.

    The sum of M = 1 / C^2 equal patterns is gamma distributed with M degrees of freedom [Goo07, Sec. 3.2];
    its cube root is nearly normal with mean ``1 - c`` and variance ``c = C^2 / 9`` (Wilson and Hilferty,
    1931).
    """
    c = contrast**2 / 9
    return np.asarray(np.maximum(1 - c + math.sqrt(c) * normal.astype(np.float64), 0) ** 3)


def gaussian_taps(width: float) -> NDArray[np.float64]:
    """Filter (2 r + 1,) that gives white noise the autocorrelation ``exp(-d^2 / (2 width^2))``.

    It has the root of the spectrum of that sequence. A sampled Gaussian, which it resembles, would correlate
    neighbours too little where `width` is about a pixel. Squares sum to 1.
    """
    reach = math.ceil(REACH * width) + 1
    length = 8 * reach
    distance = np.minimum(np.arange(length), length - np.arange(length))
    spectrum = np.fft.fft(np.exp(-0.5 * (distance / width) ** 2)).real
    taps = np.fft.ifft(np.sqrt(np.maximum(spectrum, 0))).real
    taps = np.concatenate([taps[-reach:], taps[: reach + 1]])
    return np.asarray(taps / np.sqrt((taps**2).sum()))


@dataclass(frozen=True)
class _Samples:
    """Samples of a view ordered by stripe.

    Attributes
    ----------
    shape : (n, w)
    order : (n w,) int64
        Flat index of the samples, stripe by stripe.
    stripes : (s,) int64
        Numbers of the stripes that there are.
    starts : (s + 1,) int64
        Where each begins in `order`.
    """

    shape: tuple[int, int]
    order: NDArray[np.int64]
    stripes: NDArray[np.int64]
    starts: NDArray[np.int64]

    @classmethod
    def of(cls, noise: SampleNoise) -> "_Samples":
        number = (noise.first[:, None] + np.arange(noise.width)).ravel()
        order = np.argsort(number, kind="stable")
        stripes, starts = np.unique(number[order], return_index=True)
        ends = np.append(starts, len(order)).astype(np.int64)
        return cls((len(noise.first), noise.width), order, stripes.astype(np.int64), ends)

    def field(self, noise: SampleNoise, pattern: int, width: float) -> NDArray[np.complex128]:
        """Complex noise (n, w) that is correlated over the pixels of a stripe as by `gaussian_taps`.

        Real and imaginary parts have variance 1.
        """
        stream = FIRST_STREAM + pattern
        key = np.random.SeedSequence([noise.seed, noise.view, stream]).generate_state(2, np.uint64)
        taps = gaussian_taps(width)
        out = np.empty(len(self.order), np.complex128)
        pixels = noise.pixels.astype(np.int64)

        def some(start: int, end: int) -> None:
            for k in range(start, end):
                here = self.order[self.starts[k] : self.starts[k + 1]]
                _filter_stripe(pixels, here // noise.width, here, self.stripes[k], key, taps, out)

        run_tasks(some, ranges(len(self.stripes), _STRIPES_AT_ONCE))
        return out.reshape(self.shape)


@compiled()
def _white(column: int, row: int, stripe: int, key: Any) -> complex:
    """Complex normal number of a pixel under a stripe, by Box and Muller's transform of its hash."""
    place = np.uint64(row + 65536) << np.uint64(32) | np.uint64(column + 65536)
    bits = _mixed(_mixed(_mixed(place + key[0]) + np.uint64(stripe + 65536)) + key[1])
    first = (np.float64(bits >> np.uint64(32)) + 0.5) * 2.0**-32
    angle = np.float64(bits & np.uint64(0xFFFFFFFF)) * (2 * np.pi * 2.0**-32)
    radius = np.sqrt(-2 * np.log(first))
    return radius * np.cos(angle) + 1j * (radius * np.sin(angle))


@compiled()
def _filter_stripe(
    pixels: Any, members: Any, places: Any, stripe: int, key: Any, taps: Any, out: Any
) -> None:
    """Filter the noise of a stripe at some of the pixels (n, 2), into `out` at `places`.

    Noise is made for the lit span of every row, and within the reach of the filter around it.
    """
    reach = len(taps) // 2
    top, bottom, left, right = np.int64(2**30), np.int64(-(2**30)), np.int64(2**30), np.int64(-(2**30))
    for m in members:
        left, right = min(left, pixels[m, 0]), max(right, pixels[m, 0])
        top, bottom = min(top, pixels[m, 1]), max(bottom, pixels[m, 1])
    height, width = bottom - top + 1 + 2 * reach, right - left + 1 + 2 * reach
    low, high = np.full(height, width), np.full(height, -1)  # columns in need of horizontal sums
    for m in members:
        column, row = pixels[m, 0] - left, pixels[m, 1] - top
        for y in range(row, row + 2 * reach + 1):
            low[y], high[y] = min(low[y], column), max(high[y], column)
    across = np.zeros((height, width - 2 * reach), np.complex128)
    line = np.zeros(width, np.complex128)
    for y in range(height):
        for x in range(low[y], high[y] + 2 * reach + 1):
            line[x] = _white(x + left - reach, y + top - reach, stripe, key)
        for x in range(low[y], high[y] + 1):
            total = 0j
            for k in range(2 * reach + 1):
                total += taps[k] * line[x + k]
            across[y, x] = total
    for i in range(len(members)):
        column, row = pixels[members[i], 0] - left, pixels[members[i], 1] - top
        total = 0j
        for k in range(2 * reach + 1):
            total += taps[k] * across[row + k, column]
        out[places[i]] = total
