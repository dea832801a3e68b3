"""Laser-triangulation scanner of [BLN*11], simulated with Mitsuba 3."""

from scanner_sim.scan import Scan

__all__ = ["Scan"]
