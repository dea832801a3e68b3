"""Detectors of the laser's peak in a row of samples, one a file; `scanner_sim.optics.peak` chooses.

Read `samples` (what they share) first. `reference` is that of [BLN*11], `gaussian` and `least_squares` fit a
Gaussian, `centre_of_mass`, `parabola`, `fir` and `steger` are the usual detectors of laser lines. Each gives
``detect(values, ceiling, step, out)``, compiled: of every row of `values` (n, w) it writes peak, position,
width, residual and whether it accepts (`scanner_sim.optics.peak.Peaks`) to `out` (n, 5). Samples count when
above `samples.FLOOR` and are saturated from `ceiling` (n,) on; `step` is the angle between samples, radians.
"""
