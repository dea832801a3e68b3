"""Laser-triangulation scanner of [BLN*11], simulated with Mitsuba 3.

Read `scanner_config` (every parameter; `scanner_rules`, what values they may take), `scan` (the result) and
`scanner` (one scan, step by step); then the folders ``optics`` (the physics), ``tracing`` (Mitsuba),
``motion`` (where cameras stand, the line profiler), ``presets`` (settings of known devices) and ``output``
(files for other programs). `leading_reason` says why nothing was acquired.
`ideal` samples a complete surface and measures how much of it a scan covers; `view_alignment` disturbs and
repairs the placement of the views. All but ``output`` decides scans to the last bit.

[BLN*11] Berger, Levine, Nonato, Taubin, Silva, "An end-to-end framework for evaluating surface
reconstruction", SCI Technical Report UUSCI-2011-001.
"""

from scanner_sim.ideal import coverage, sample
from scanner_sim.output.contact_sheet import write_contact_sheet
from scanner_sim.output.range_images import write_range_images
from scanner_sim.scan import Scan
from scanner_sim.scanner import estimated_normals, scan
from scanner_sim.scanner_config import ScannerConfig
from scanner_sim.tracing.materials import MATERIALS
from scanner_sim.tracing.variant import variant_report

__all__ = [
    "MATERIALS",
    "Scan",
    "ScannerConfig",
    "coverage",
    "estimated_normals",
    "sample",
    "scan",
    "variant_report",
    "write_contact_sheet",
    "write_range_images",
]
