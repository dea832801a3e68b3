"""Passes of a line profiler: how rig and part move while the sheet crosses the object."""

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError
from scanner_sim.optics import stripe
from scanner_sim.scanner_config import ScannerConfig

MOST_FRAMES = 10_000
"""Of one pass."""
SLOWEST = 1e-3
"""Slowest advance of the sheet over the object that counts as one, relative to the step of the rig."""

Array = NDArray[np.float64]


@dataclass(frozen=True)
class Pass:
    """One travel of the rig along the first camera's x, past the object. Vectors are in the rig, mm.

    Attributes
    ----------
    frames : int
    start : (3,) float64
        From the pose of the view to that of frame 0.
    travel : (3,) float64
        Of the rig from one frame to the next.
    drift : (3,) float64
        Of the part from one frame to the next; it is where the mesh is in the middle of the pass.
    sheet : (3,) float64
        Direction in which the sheet leaves the laser, perpendicular to the laser's axis.
    """

    frames: int
    start: Array
    travel: Array
    drift: Array
    sheet: Array

    def part_shift(self, frame: int) -> Array:
        """Displacement of the part in a frame, (3,)."""
        return self.drift * (frame - (self.frames - 1) / 2)

    def track(self) -> Array:
        """How the rig stands to the part in each frame, from its pose in frame 0 on, (frames, 3)."""
        return np.arange(self.frames)[:, None] * self.travel - np.array(
            [self.part_shift(frame) for frame in range(self.frames)]
        )

    def angle(self, pose: Array) -> float:
        """Sheet angle in the coordinates of a camera, radians."""
        return math.atan2(float(self.sheet @ pose[:3, 0]), float(self.sheet @ pose[:3, 2]))


def plan_all(vertices: Array, poses: Array, config: ScannerConfig) -> list[Pass]:
    """The pass of each pose of the first camera, (V, 4, 4); parameters and errors as for `plan`."""
    return [plan(vertices, pose, config, view) for view, pose in enumerate(poses)]


def plan(vertices: Array, pose: Array, config: ScannerConfig, view: int = 0) -> Pass:
    """The pass in which the sheet crosses all of the object.

    The sheet is aimed at the depth D of the object's centre, where it meets the camera's axis:
    ``theta = atan2(-b, D)``. The sheet meets a point (x, y, z) of the first camera's coordinates in the frame
    k, counted from the middle of the pass, with ``k (step - v_x + v_z tan(theta)) = x - b - z tan(theta)``.

    Parameters
    ----------
    vertices : (n, 3)
        In the rig, mm.
    pose : (4, 4)
        Of the first camera.
    config
    view
        Number in messages.

    Raises
    ------
    InputError
        If the object's centre lies behind the camera, or the sheet does not cross the object within
        `MOST_FRAMES`.
    """
    turn = pose[:3, :3]
    depth = -float(pose[:3, 3] @ turn[:, 2])  # of the origin
    if depth <= 0:
        raise InputError(f"view {view} has the object behind the camera; turn its pose, z is forward")
    theta = math.atan2(-config.baseline, depth)
    local = (vertices - pose[:3, 3]) @ turn
    ahead = local[:, 0] - config.baseline - math.tan(theta) * local[:, 2]
    velocity = np.array(config.part_velocity)
    advance = config.profile_step - velocity[0] + math.tan(theta) * velocity[2]
    length = float(np.ptp(ahead))
    if abs(advance) < SLOWEST * config.profile_step:
        raise InputError(
            f"part_velocity {config.part_velocity} mm per frame keeps the object off the sheet, which never "
            f"crosses it at a profile_step of {config.profile_step} mm; change one of them"
        )
    frames = math.ceil(length / abs(advance)) + 1
    if frames > MOST_FRAMES:
        raise InputError(
            f"the sheet advances over the object by {abs(advance):.3g} mm per frame: a pass takes {frames} "
            f"frames, more than {MOST_FRAMES}; raise profile_step or change part_velocity"
        )
    middle = (float(ahead.min()) + float(ahead.max())) / 2
    return Pass(
        frames,
        (middle - config.profile_step * (frames - 1) / 2) * turn[:, 0],
        config.profile_step * turn[:, 0],
        turn @ velocity,
        math.sin(theta) * turn[:, 0] + math.cos(theta) * turn[:, 2],
    )


def lit_outline(local: Array, faces: NDArray[np.integer], angle: float, config: ScannerConfig) -> Array:
    """Points whose convex hull holds the part of a mesh that the sheet lights.

    Parameters
    ----------
    local : (v, 3)
        Vertices in camera coordinates, mm.
    faces : (f, 3)
    angle
        Of the sheet, radians.
    config

    Returns
    -------
    (k, 3) float64
        In camera coordinates: lit vertices, and where edges leave the light.
    """
    laser = stripe.laser_coordinates(local, config.baseline)
    half = float(stripe.half_angle(laser, config).max(initial=0))
    half += 4 * config.translucency / max(float(laser.axis_distance.min(initial=np.inf)), 1.0)
    half = min(half, 0.4)
    x, z = local[:, 0] - config.baseline, local[:, 2]
    sides = [math.cos(angle + s * half) * x - math.sin(angle + s * half) * z for s in (1, -1)]
    right, left = sides[0] > 0, sides[1] < 0
    touched = faces[~(right[faces].all(axis=1) | left[faces].all(axis=1))]
    found = [local[np.unique(touched[~(right | left)[touched]])]]
    edges = touched[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2)
    for side in sides:
        a, b = side[edges[:, 0]], side[edges[:, 1]]
        crossing = (a < 0) != (b < 0)
        share = (a / np.where(crossing, a - b, 1))[crossing, None]
        start, end = local[edges[crossing, 0]], local[edges[crossing, 1]]
        found.append(start + share * (end - start))
    return np.concatenate(found)
