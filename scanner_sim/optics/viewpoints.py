"""Sets of viewpoints, camera poses of the user's own, and the poses of both cameras of a rig."""

import functools
import re
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.points.fibonacci import fibonacci_sphere
from datasets_gen.records import InputError

Views = int | str | tuple[tuple[float, float, float], ...] | tuple[tuple[tuple[float, ...], ...], ...]
"""A count, the name of a set, directions, or 4 x 4 matrices."""

MOST_VIEWS = 1000
MOST_RELAXED = 64
"""Larger sets stay spherical Fibonacci points, which are as even."""
STEEPEST = 85.0
"""Largest elevation of a turntable's camera, degrees; from straight above, no direction is up."""
SKEW = 1e-4
"""Largest deviation of a rotation matrix from an orthonormal one, as of numbers with few digits."""
SIDES = {"front": 0.0, "left": 90.0, "back": 180.0, "right": 270.0}
"""Sides of a body that faces the front, degrees about the up axis, counter-clockwise as seen from above."""
MOST_ASIDE = 3
"""Cameras of a rig on one side; a fourth would look at the next side."""
ASIDE = 60.0
"""Degrees about the up axis between the cameras of a rig on one side."""
_AXES = {"x": 0, "y": 1, "z": 2}
_FORMS = (
    f"give a count of 1..{MOST_VIEWS}, 'sphere:N', 'ring:N', 'opposed', 'turntable:N', "
    f"'turntable:N@ELEVATION', 'front:N', 'back:N', 'left:N' or 'right:N' with N of 1..{MOST_ASIDE}, "
    "a list of directions or a list of 4 x 4 camera-to-mesh matrices"
)


def check_views(views: Views) -> None:
    """Raise InputError if `views` names no set of viewpoints."""
    if matrices(views) is None:
        directions(views)


def as_tuples(views: Any) -> Views:
    """Directions or matrices as nested tuples, from nested lists or arrays; checked."""
    if isinstance(views, int | str):
        return views
    check_views(views)
    nested = np.array(views, dtype=np.float64)
    if nested.ndim == 2:
        return tuple((float(x), float(y), float(z)) for x, y, z in nested)
    return tuple(tuple(tuple(map(float, row)) for row in matrix) for matrix in nested)


def matrices(views: Views) -> NDArray[np.float64] | None:
    """Camera-to-mesh matrices given by the user, in the mesh's frame and units; None if `views` are others.

    Parameters
    ----------
    views
        As for `directions`; matrices are a list of V nested lists of 4 rows.

    Returns
    -------
    (V, 4, 4) float64 or None
        With x right, y down and z forward (as in OpenCV), their rotations the orthonormal ones nearest to
        what was given.

    Raises
    ------
    InputError
        If a matrix is not finite, its last row is not (0, 0, 0, 1), or it does more than rotate and move.
    """
    if isinstance(views, int | str):
        return None
    try:
        given = np.array(views, dtype=np.float64)
    except (TypeError, ValueError):
        return None
    if given.ndim != 3:
        return None
    if given.shape[1:] != (4, 4) or len(given) > MOST_VIEWS:
        raise InputError(f"views must be 1..{MOST_VIEWS} matrices of 4 x 4 numbers, got {given.shape}")
    out = given.copy()
    for number, pose in enumerate(out):
        turn = pose[:3, :3]
        if not np.isfinite(pose).all() or not np.array_equal(pose[3], [0, 0, 0, 1]):
            raise InputError(
                f"views: matrix {number} must be finite with the last row (0, 0, 0, 1), got {pose.tolist()}"
            )
        if np.abs(turn @ turn.T - np.eye(3)).max() > SKEW or np.linalg.det(turn) < 0:
            raise InputError(
                f"views: the upper left of matrix {number} is no rotation, got {turn.tolist()}; its columns "
                "must be unit vectors to the image's right, down and forward"
            )
        left, _, right = np.linalg.svd(turn)
        pose[:3, :3] = left @ right
    return out


def directions(views: Views, up: str = "y") -> NDArray[np.float64]:
    """Unit directions from the object's centre to the viewpoints.

    Parameters
    ----------
    views
        A count, ``"sphere:N"``, ``"ring:N"``, ``"opposed"``, ``"turntable:N"``, ``"turntable:N@ELEVATION"``,
        ``"front:N"``, ``"back:N"``, ``"left:N"``, ``"right:N"`` or explicit directions. A turntable turns the
        part about `up` by 360/N degrees between two views, counter-clockwise as seen from above, so that the
        camera goes round it clockwise; it starts at the front and looks down on the part by the elevation,
        degrees. A rig on one side has N cameras level with the centre, `ASIDE` degrees apart and spread
        evenly about that side, counter-clockwise as seen from above.
    up
        Axis that is up; the front is the axis that follows it in x, y, z, x, and the left of what faces the
        front is the third.

    Returns
    -------
    (V, 3) float64

    Raises
    ------
    InputError
        If the set is unknown or empty.
    """
    if isinstance(views, bool) or not isinstance(views, int | str):
        return _explicit(views)
    kind, count, elevation = _parse(views)
    order = np.roll(np.arange(3), 1 - _AXES[up])  # y-up coordinates -> the mesh's
    if kind == "sphere":
        local = _sphere(count)
    elif kind in SIDES:
        local = _aside(kind, count)
    else:
        local = _ring(count) if kind == "ring" else _turntable(count, elevation)
    out = np.empty_like(local)
    out[:, order] = local
    return out


def _parse(views: int | str) -> tuple[str, int, float]:
    """Kind, count and elevation (degrees) of a set that is given by count or name."""
    if isinstance(views, int):
        kind, count, elevation = "sphere", views, 0.0
    else:
        text = "ring:2" if views == "opposed" else views
        kinds = "|".join(("sphere", "ring", "turntable", *SIDES))
        found = re.fullmatch(rf"({kinds}):(\d{{1,9}})(@[-+]?\d+(\.\d*)?)?", text, re.ASCII)
        kind, count, elevation = "", 0, 0.0
        if found and (found[3] is None or found[1] == "turntable"):
            kind, count, elevation = found[1], int(found[2]), float((found[3] or "@0")[1:])
    if not 1 <= count <= (MOST_ASIDE if kind in SIDES else MOST_VIEWS):
        raise InputError(f"views {views!r} is unknown; {_FORMS}")
    if abs(elevation) > STEEPEST:
        raise InputError(f"views {views!r}: the elevation must lie in -{STEEPEST:g}..{STEEPEST:g} degrees")
    return kind, count, elevation


def _explicit(views: object) -> NDArray[np.float64]:
    """Normalised directions given by the user."""
    try:
        given = np.array(views, dtype=np.float64)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.ndim != 2 or given.shape[1] != 3 or len(given) == 0:
        raise InputError(f"views {views!r} is no list of (x, y, z) directions or 4 x 4 matrices")
    lengths = np.linalg.norm(given, axis=1, keepdims=True)
    if not (np.isfinite(given).all() and (lengths > 0).all()):
        raise InputError(f"views {views!r} holds a direction that is zero or not finite")
    return given / lengths


def _ring(count: int) -> NDArray[np.float64]:
    """Equally spaced about y, starting at +z, (count, 3)."""
    return _level(2 * np.pi * np.arange(count) / count)


def _level(angle: NDArray[np.float64]) -> NDArray[np.float64]:
    """Across y at angles from +z towards +x, radians, (count, 3)."""
    return np.stack([np.sin(angle), np.zeros(len(angle)), np.cos(angle)], axis=1)


def _aside(side: str, count: int) -> NDArray[np.float64]:
    """Across y and spread evenly about one side, counter-clockwise as seen from above, (count, 3)."""
    return _level(np.radians(SIDES[side] + ASIDE * (np.arange(count) - (count - 1) / 2)))


def _turntable(count: int, elevation: float) -> NDArray[np.float64]:
    """Clockwise about y as seen from above, starting at +z, raised by the elevation (degrees), (count, 3)."""
    rise = np.radians(elevation)
    return _ring(count) * [-np.cos(rise), 0, np.cos(rise)] + [0, np.sin(rise), 0]


@functools.lru_cache(maxsize=16)
def _sphere_points(count: int) -> tuple[tuple[float, float, float], ...]:
    """Spherical Fibonacci points relaxed by mutual repulsion, the first turned to the front (+z)."""
    from scipy.optimize import minimize  # a sixth of a second to import

    points = fibonacci_sphere(count)
    if 1 < count <= MOST_RELAXED:
        points = minimize(_repulsion, points.ravel(), jac=True, method="L-BFGS-B").x.reshape(-1, 3)
        points /= np.linalg.norm(points, axis=1, keepdims=True)
    points = points @ _turning(points[0])
    return tuple((float(a), float(b), float(c)) for a, b, c in points)


def _repulsion(flat: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
    """Coulomb energy of equal charges at the directions of n vectors, and its gradient, (3 n,)."""
    vectors = flat.reshape(-1, 3)
    length = np.linalg.norm(vectors, axis=1, keepdims=True)
    points = vectors / length
    gap = points[:, None] - points[None]
    distance = np.linalg.norm(gap, axis=2)
    np.fill_diagonal(distance, np.inf)
    slope = -(gap / distance[..., None] ** 3).sum(axis=1)
    slope -= (slope * points).sum(axis=1, keepdims=True) * points
    return float((1 / distance).sum() / 2), (slope / length).ravel()


def _turning(direction: NDArray[np.float64]) -> NDArray[np.float64]:
    """Matrix that turns row vectors so that a direction becomes +z, about an axis perpendicular to both."""
    x, y, z = direction
    if z < -0.999999:
        return np.diag([1.0, -1.0, -1.0])
    cross = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]]) @ np.array([0.0, 0.0, 1.0])
    k = np.array([[0, -cross[2], cross[1]], [cross[2], 0, -cross[0]], [-cross[1], cross[0], 0]])
    return (np.eye(3) + k + k @ k / (1 + z)).T


def _sphere(count: int) -> NDArray[np.float64]:
    """Near-uniform directions, (count, 3)."""
    return np.array(_sphere_points(count))


def poses(toward: NDArray[np.float64], distance: float, up: str = "y") -> NDArray[np.float64]:
    """Camera-to-world matrices of cameras that look at the origin.

    Camera coordinates: x to the image's right, y down, z forward (as in OpenCV).

    Parameters
    ----------
    toward : (V, 3)
        Unit directions from the origin to the eyes.
    distance
        Of the eyes from the origin.
    up
        Axis that is up in the images; seen along it, the front axis is up instead.

    Returns
    -------
    (V, 4, 4) float64
    """
    axis = np.eye(3)[_AXES[up]]
    front = np.eye(3)[(_AXES[up] + 1) % 3]
    out = np.zeros((len(toward), 4, 4))
    for pose, direction in zip(out, toward, strict=True):
        reference = axis if abs(direction @ axis) < 0.999 else front
        right = np.cross(reference, direction)
        right /= np.linalg.norm(right)
        pose[:3, 0], pose[:3, 1], pose[:3, 2] = right, np.cross(right, direction), -direction
        pose[:3, 3] = distance * direction
        pose[3, 3] = 1
    return out


def second_camera(poses: NDArray[np.float64], baseline: float, depth: float) -> NDArray[np.float64]:
    """Poses of the second camera: the mirror images of the first in a plane through the laser's axis.

    The plane is the sheet that meets the first camera's axis at a depth D. Both cameras so look at one point
    there, from both sides of the sheet, and the second camera's laser is at ``-baseline``: its x and z axes
    are those of the first, turned about y by ``2 atan(baseline / D)`` about the laser. (A second camera
    parallel to the first would have the object outside its image at usual baselines.)

    Parameters
    ----------
    poses : (V, 4, 4)
        Of the first camera.
    baseline
        Of the laser along the first camera's x.
    depth
        D, in the unit of the baseline and of the poses.

    Returns
    -------
    (V, 4, 4) float64
    """
    turn = 2 * np.arctan2(baseline, depth)
    x, z = poses[:, :3, 0], poses[:, :3, 2]
    out = poses.copy()
    out[:, :3, 0] = np.cos(turn) * x + np.sin(turn) * z
    out[:, :3, 2] = np.cos(turn) * z - np.sin(turn) * x
    out[:, :3, 3] += baseline * (x + out[:, :3, 0])
    return out
