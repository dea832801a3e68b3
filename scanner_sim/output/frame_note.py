"""What files say of the frame and the units of their coordinates."""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from scanner_sim.scan import Scan

CAMERA_AXES = "x right, y down, z forward"
"""Of the matrices in `Scan.poses`, as in OpenCV."""


def frame_note(scan: "Scan") -> tuple[str, str, str]:
    """Three lines of ASCII: what was scanned, frame and units, and the scanner's millimetres.

    Each is shorter than 200 characters, which some readers of headers cannot exceed.
    """
    name = scan.shape_name.encode("ascii", "replace").decode()
    return (
        f"medialbench scan of {name[:120]}, seed {scan.seed}",
        "frame: that of the scanned mesh, right-handed; unit: the unit of its vertices",
        f"{scan.scale!r} mm of the scanner per unit, peak threshold {scan.config.peak_threshold}",
    )
