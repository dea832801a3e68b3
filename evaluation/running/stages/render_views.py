"""Renders: all that the scanner acquires of one pose, at the lowest threshold of interest."""

from collections.abc import Mapping
from typing import Any

from evaluation.running.stages.interface import Inputs, Output
from scanner_sim import ScannerConfig, scan


def compute(spec: Mapping[str, Any], inputs: Inputs) -> Output:
    """Scan a pose from all viewpoints.

    ``spec``: ``pose``, ``scanner`` (fields of `ScannerConfig`), ``seed``. Inputs: ``shape``.

    Info: ``points``, and ``variant``: the Mitsuba variant that traced them.
    """
    shape = inputs.load("shape")[spec["pose"]]
    found = scan(shape, ScannerConfig.from_dict(spec["scanner"]), seed=spec["seed"])
    return Output(found.save, {"points": len(found), "variant": found.variant})
