"""Laser-triangulation scanner of [BLN*11], simulated with Mitsuba 3."""

from scanner_sim.config import ScannerConfig
from scanner_sim.ideal import coverage, sample
from scanner_sim.output.export import write_range_images
from scanner_sim.output.preview import preview
from scanner_sim.scan import Scan
from scanner_sim.scanner import estimated_normals, scan
from scanner_sim.tracing.materials import MATERIALS
from scanner_sim.tracing.variant import variant_report

__all__ = [
    "MATERIALS",
    "Scan",
    "ScannerConfig",
    "coverage",
    "estimated_normals",
    "preview",
    "sample",
    "scan",
    "variant_report",
    "write_range_images",
]
