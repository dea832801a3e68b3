"""Surfaces as Mitsuba BSDFs."""

from typing import Any

from scanner_sim.config import ScannerConfig


def bsdf(mi: Any, config: ScannerConfig) -> Any:
    """The surface of a configuration."""
    return mi.load_dict({"type": "diffuse", "reflectance": {"type": "rgb", "value": 1.0}})
