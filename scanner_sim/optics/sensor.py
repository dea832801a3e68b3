"""The camera's sensor: from light to stored intensities."""

import numpy as np
from numpy.typing import NDArray

from scanner_sim.scanner_config import ScannerConfig

Values = NDArray[np.float64]


def expose(light: Values, cast: Values, config: ScannerConfig, rng: np.random.Generator) -> Values:
    """Stored intensities of the light that a pixel receives.

    In order: exposure, the reference's speckle, shot noise, read noise, gain, saturation and quantisation.

    Parameters
    ----------
    light : (n, w)
        1 is a white surface that faces the laser.
    cast : (n, w)
        Relative radiance of the stripe itself, which bounds the speckle.
    config
    rng
        Source of all noise.

    Returns
    -------
    (n, w) float64
        In [0, 1]; exactly 1 where saturated.
    """
    values = light * config.exposure
    if config.noise > 0:
        values = values - speckle(cast, config.noise, rng)
    if config.full_well > 0:
        values = shot(values, config.full_well, rng)
    if config.read_noise > 0:
        values = values + config.read_noise * rng.standard_normal(values.shape)
    return quantise(values * config.gain, config.bits)


def speckle(cast: Values, magnitude: float, rng: np.random.Generator) -> Values:
    """Additive noise ``min(L, A) exp(-2 z^2)``, z normal [BLN*11]: what is taken from the intensity."""
    return np.minimum(cast, magnitude) * np.exp(-2 * rng.standard_normal(cast.shape) ** 2)


def shot(values: Values, full_well: int, rng: np.random.Generator) -> Values:
    """Poisson noise of counting ``values * full_well`` electrons."""
    return rng.poisson(np.maximum(values, 0) * full_well) / full_well


def quantise(values: Values, bits: int) -> Values:
    """Clip to [0, 1] and round to ``2**bits - 1`` steps; 0 bits only clip."""
    clipped = np.clip(values, 0, 1)
    if bits == 0:
        return clipped
    levels = 2**bits - 1
    return np.round(clipped * levels) / levels
