"""Laser-triangulation scanner of [BLN*11], simulated with Mitsuba 3."""

from scanner_sim.config import ScannerConfig
from scanner_sim.ideal import coverage, sample
from scanner_sim.materials import MATERIALS
from scanner_sim.scan import Scan
from scanner_sim.scanner import estimated_normals, scan

__all__ = ["MATERIALS", "Scan", "ScannerConfig", "coverage", "estimated_normals", "sample", "scan"]
