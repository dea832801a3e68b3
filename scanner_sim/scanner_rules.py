"""What values the scanner's parameters may take."""

import json
import math
from collections.abc import Callable, Mapping
from typing import Any

from datasets_gen.records import InputError

ScannerConfig = Any
"""`scanner_sim.scanner_config.ScannerConfig`, which imports this module."""
_LENGTHS = ("object_size", "min_range", "beam_waist", "wavelength", "profile_step", "speckle_size")
_POSITIVE = (*_LENGTHS, "exposure", "gain", "std_threshold", "residual_threshold")
_Rule = tuple[str, Callable[[ScannerConfig], bool], str]
_RULES: list[_Rule] = [
    *[(name, lambda c, name=name: getattr(c, name) > 0, "be positive") for name in _POSITIVE],
    ("resolution", lambda c: min(c.resolution) >= 8, "be at least (8, 8)"),
    ("resolution", lambda c: max(c.resolution) <= 20_000, "be at most (20000, 20000)"),
    ("stripes", lambda c: c.stripes <= 20_000, "be at most 20000"),
    ("speckle_size", lambda c: c.speckle_size <= 100, "be at most 100 pixels"),
    ("full_well", lambda c: c.full_well <= 1e12, "be at most 1e12"),
    ("material", lambda c: isinstance(c.material, str | Mapping), "be a name or a table"),
    ("field_of_view", lambda c: 0 < c.field_of_view < 180, "lie in (0, 180) degrees"),
    ("distortion", lambda c: _invertible(c), "be weak enough to be inverted within the image"),
    ("baseline", lambda c: c.baseline != 0, "not be 0: without a baseline nothing can be triangulated"),
    ("max_range", lambda c: c.max_range > c.min_range, "exceed min_range"),
    ("distance", lambda c: c.distance is None or c.distance > 0, "be positive"),
    ("stripes", lambda c: c.stripes >= 3, "be at least 3: a peak has three unknowns"),
    ("stripe_width", lambda c: c.stripe_width is None or 0 < c.stripe_width < 90, "lie in (0, 90) degrees"),
    ("smoothing", lambda c: 0 <= c.smoothing <= 10, "lie in [0, 10] pixels"),
    ("bounces", lambda c: c.bounces >= 1, "be at least 1"),
    (
        "bounces",
        lambda c: c.bounces == 1 or _renderable(c),
        "be 1 unless falloff is 'inverse_square', beam 'wedge', and smoothing and distortion are 0",
    ),
    (
        "part_velocity",
        lambda c: c.motion == "profiler" or not any(c.part_velocity),
        "be 0 unless motion is 'profiler'",
    ),
    ("bounces", lambda c: c.bounces == 1 or c.motion == "sweep", "be 1 for a profiler"),
    ("noise", lambda c: 0 <= c.noise <= 1, "lie in [0, 1]"),
    ("smoothing_stage", lambda c: c.smoothing_stage == "light" or c.bounces == 1, "be 'light' with bounces"),
    ("footprint", lambda c: c.footprint % 2 == 1 and 1 <= c.footprint <= 15, "be an odd number in 1..15"),
    ("footprint", lambda c: c.footprint == 1 or c.bounces == 1, "be 1 with more than one bounce"),
    ("ambient", lambda c: c.ambient >= 0, "not be negative"),
    ("crease_angle", lambda c: 0 <= c.crease_angle <= 180, "lie in [0, 180] degrees"),
    ("translucency", lambda c: 0 <= c.translucency <= 10, "lie in [0, 10] mm"),
    ("refractive_index", lambda c: 1 <= c.refractive_index <= 4, "lie in [1, 4]"),
    ("background", lambda c: c.background is None or c.background > 0, "be positive"),
    ("focal_error", lambda c: abs(c.focal_error) < 0.5, "lie in (-0.5, 0.5)"),
    ("baseline_error", lambda c: abs(c.baseline_error) < abs(c.baseline), "be smaller than the baseline"),
    ("sheet_error", lambda c: abs(c.sheet_error) <= 10, "lie in [-10, 10] degrees"),
    ("speckle_contrast", lambda c: 0 <= c.speckle_contrast <= 1, "lie in [0, 1]"),
    ("dark_level", lambda c: 0 <= c.dark_level < 1, "lie in [0, 1)"),
    ("full_well", lambda c: c.full_well >= 0, "not be negative"),
    ("read_noise", lambda c: c.read_noise >= 0, "not be negative"),
    ("bits", lambda c: 0 <= c.bits <= 16, "lie in 0..16"),
    ("peak_threshold", lambda c: 0 < c.peak_threshold <= 1, "lie in (0, 1]"),
    ("depth_threshold", lambda c: c.depth_threshold is None or c.depth_threshold > 0, "be positive"),
    ("registration_error", lambda c: 0 <= c.registration_error <= 45, "lie in [0, 45] degrees"),
    ("neighbours", lambda c: c.neighbours >= 3, "be at least 3"),
]


def _renderable(config: ScannerConfig) -> bool:
    """Whether Mitsuba's own emitters and sensors can render the stripes."""
    physical = config.falloff == "inverse_square" and config.beam == "wedge"
    return physical and config.smoothing == 0 and not any(config.distortion)


def _invertible(config: ScannerConfig) -> bool:
    """Whether the distorted radius grows with the radius, over the image and some way beyond."""
    k1, k2 = config.distortion
    corner = 1.5 * math.hypot(*config.resolution) / 2 / config.focal
    squares = [(corner * i / 64) ** 2 for i in range(65)]
    return all(1 + 3 * k1 * s + 5 * k2 * s * s > 0.3 for s in squares)


def check_values(config: ScannerConfig) -> None:
    """Raise InputError for the first impossible value."""
    for name, holds, rule in _RULES:
        if not holds(config):
            raise InputError(f"scanner setting {name} must {rule}, got {getattr(config, name)!r}")
    if config.beam == "wedge" and 3 * config.step > config.wedge:
        raise InputError(
            f"a stripe of {math.degrees(config.wedge):.3g} degrees is lit in fewer than 3 of the steps of "
            f"{math.degrees(config.step):.3g} degrees; raise stripes (now {config.stripes}) or stripe_width"
        )
    try:
        json.dumps(config.material)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"scanner setting material must be a name or a table of plain values: {error}"
        ) from error
