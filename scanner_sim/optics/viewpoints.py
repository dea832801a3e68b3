"""Fixed sets of viewpoints and the camera poses on them."""

import functools

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize

from datasets_gen.records import InputError

Views = int | str | tuple[tuple[float, float, float], ...]
"""A count, the name of a set, or directions."""

MOST_VIEWS = 1000
MOST_RELAXED = 64
"""Larger sets stay spherical Fibonacci points, which are as even."""
_AXES = {"x": 0, "y": 1, "z": 2}


def check_views(views: Views) -> None:
    """Raise InputError if `views` names no set of viewpoints."""
    directions(views)


def directions(views: Views, up: str = "y") -> NDArray[np.float64]:
    """Unit directions from the object's centre to the viewpoints.

    Parameters
    ----------
    views
        A count, ``"sphere:N"``, ``"ring:N"``, ``"opposed"`` or explicit directions.
    up
        Axis that is up; the front is the axis that follows it in x, y, z, x.

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
    kind, count = _parse(views)
    order = np.roll(np.arange(3), 1 - _AXES[up])  # y-up coordinates -> the mesh's
    local = _sphere(count) if kind == "sphere" else _ring(count)
    out = np.empty_like(local)
    out[:, order] = local
    return out


def _parse(views: int | str) -> tuple[str, int]:
    """Kind and count of a set that is given by count or name."""
    if isinstance(views, int):
        kind, count = "sphere", views
    elif views == "opposed":
        kind, count = "ring", 2
    else:
        kind, _, number = views.partition(":")
        count = int(number) if number.isdecimal() else 0
    if kind not in ("sphere", "ring") or not 1 <= count <= MOST_VIEWS:
        raise InputError(
            f"views {views!r} is unknown; give a count of 1..{MOST_VIEWS}, 'sphere:N', 'ring:N', "
            "'opposed' or a list of directions"
        )
    return kind, count


def _explicit(views: object) -> NDArray[np.float64]:
    """Normalised directions given by the user."""
    try:
        given = np.array(views, dtype=np.float64)
    except (TypeError, ValueError):
        given = np.empty(0)
    if given.ndim != 2 or given.shape[1] != 3 or len(given) == 0:
        raise InputError(f"views {views!r} is no list of (x, y, z) directions")
    lengths = np.linalg.norm(given, axis=1, keepdims=True)
    if not (np.isfinite(given).all() and (lengths > 0).all()):
        raise InputError(f"views {views!r} holds a direction that is zero or not finite")
    return given / lengths


def _ring(count: int) -> NDArray[np.float64]:
    """Equally spaced about y, starting at +z, (count, 3)."""
    angle = 2 * np.pi * np.arange(count) / count
    return np.stack([np.sin(angle), np.zeros(count), np.cos(angle)], axis=1)


@functools.lru_cache(maxsize=16)
def _sphere_points(count: int) -> tuple[tuple[float, float, float], ...]:
    """Spherical Fibonacci points relaxed by mutual repulsion, the first turned to the front (+z)."""
    golden = np.pi * (3 - np.sqrt(5))
    index = np.arange(count)
    y = 1 - (2 * index + 1) / count
    radius = np.sqrt(1 - y**2)
    points = np.stack([radius * np.cos(golden * index), y, radius * np.sin(golden * index)], axis=1)
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
