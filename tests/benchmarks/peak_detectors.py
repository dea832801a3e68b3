"""The table of peak detectors in `docs/scanner.md`: their bias, noise and speed against theory.

python -m tests.benchmarks.peak_detectors
"""

import math
import sys
import time

import numpy as np

from scanner_sim.optics import peak
from scanner_sim.scanner_config import ScannerConfig
from tests.scanner_sim.optics.detectors.test_least_squares import bound

STEP = ScannerConfig().step
HALF = ScannerConfig().wedge / 2 / STEP
"""Half of the default stripe, in samples; its width s follows."""

WIDTH = HALF / math.sqrt(8)
SAMPLES = np.arange(13.0)
SHIFTS = np.linspace(-0.5, 0.5, 41)
ROWS = 2000
"""Rows with noise at every shift."""

HEIGHT = 0.8


def say(line):
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def stripe(place):
    """The default stripe as a surface that faces the laser reflects it."""
    offset = SAMPLES - place
    return np.exp(-((offset / WIDTH) ** 2)) * (np.abs(offset) <= HALF)


def quantised(values, bits=8):
    return np.round(np.clip(values, 0, 1) * (2**bits - 1)) / (2**bits - 1)


def errors(values, place, method):
    """Error of the position, samples; NaN where the scanner's default thresholds reject the peak."""
    found = peak.fit(values, method, np.ones(len(values)), STEP)
    good = (found.residual <= 0.15) & (found.width <= 1.5 * WIDTH)
    if method == "reference":
        good = found.accepted & (found.width <= 1.5 * HALF)
    return np.where(good, found.position - place, np.nan)


def noise(make, method):
    """Deviation about the mean at each shift, samples, and the share of accepted peaks."""
    place = np.repeat(6 + SHIFTS, ROWS)
    error = errors(make(stripe(place[:, None])), place, method).reshape(len(SHIFTS), ROWS)
    return math.sqrt(np.nanmean(np.nanvar(error, axis=1))), np.isfinite(error).mean()


def root_mean_square(make, method):
    """Total error of accepted peaks, samples, and their share."""
    place = np.repeat(6 + SHIFTS, ROWS)
    error = errors(make(stripe(place[:, None])), place, method)
    return math.sqrt(np.nanmean(error**2)), np.isfinite(error).mean()


def milliseconds(method):
    """Least time for 100,000 noise-free rows of 9 samples and all cosines."""
    rng = np.random.default_rng(0)
    place = rng.uniform(5.5, 6.5, (100_000, 1))
    values = quantised(stripe(place) * np.sqrt(rng.uniform(0.01, 1, (100_000, 1))))[:, 2:11]
    best = np.inf
    for _ in range(7):
        begin = time.perf_counter()
        peak.fit(values, method, np.ones(len(values)), STEP)
        best = min(best, time.perf_counter() - begin)
    return 1000 * best


def white(sigma, rng):
    return lambda cast: HEIGHT * (cast + sigma * rng.standard_normal(cast.shape))


def speckled(cast, rng):
    """The reference's speckle of magnitude .35, in 8 bits."""
    taken = np.minimum(cast, 0.35) * np.exp(-2 * rng.standard_normal(cast.shape) ** 2)
    return quantised(HEIGHT * cast - taken)


def overexposed(cast, rng):
    """Twice the light that the sensor can tell, with 1 % of white noise."""
    return np.minimum(2 * (cast + 0.01 * rng.standard_normal(cast.shape)), 1)


def row(method):
    """One line of the table; every detector sees the same noise."""
    bias = np.ptp(errors(HEIGHT * stripe(6 + SHIFTS[:, None]), 6 + SHIFTS, method))
    ratios = []
    for sigma in (0.01, 0.05):
        best = np.sqrt(np.mean([bound(SAMPLES, 1, 6 + each, WIDTH, sigma) ** 2 for each in SHIFTS]))
        ratios.append(noise(white(sigma, np.random.default_rng(1)), method)[0] / best)
    bits = root_mean_square(quantised, method)[0]
    speckle, kept = root_mean_square(lambda cast: speckled(cast, np.random.default_rng(2)), method)
    saturated, left = root_mean_square(lambda cast: overexposed(cast, np.random.default_rng(3)), method)
    return (
        f"| {method} | {bias:.4f} | {ratios[0]:.2f} | {ratios[1]:.2f} | {bits:.4f} | {speckle:.3f} "
        f"({100 * kept:.0f} %) | {saturated:.4f} ({100 * left:.0f} %) | {milliseconds(method):.0f} |"
    )


def main():
    say(f"stripe of s = {WIDTH:.3f} samples, peak {HEIGHT}\n")
    say("| detector | bias | 1 % / bound | 5 % / bound | 8 bits | speckle .35 | exposed x 2 | ms |")
    say("|---|---|---|---|---|---|---|---|")
    for method in peak.DETECTORS:
        say(row(method))


if __name__ == "__main__":
    main()
