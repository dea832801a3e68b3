"""Parameters of the scanner."""

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class ScannerConfig:
    """To be completed by the scanner package."""

    peak_threshold: float = 0.1
    """Smallest accepted fitted peak, in (0, 1]; tau of the sweeps."""
