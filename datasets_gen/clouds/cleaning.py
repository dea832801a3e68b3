"""What can be put right in a cloud, each with a remark, and what makes it unusable: numbers that are none."""

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from datasets_gen.checks import LARGEST
from datasets_gen.clouds.point_cloud import PointCloud, counted
from datasets_gen.points.missing_normals import filled_normals
from datasets_gen.records import InputError

MOST_LACKING = 0.1
"""Share of points without a normal up to which the others' are kept."""


def without_gaps(cloud: PointCloud, where: str) -> PointCloud:
    """A cloud without points that are NaN or infinite, as scanners write for pixels that saw nothing.

    Raises
    ------
    InputError
        If no points are left.
    """
    sound: NDArray[np.bool_] = np.asarray(np.isfinite(cloud.points).all(axis=1))
    if sound.all():
        return cloud
    lost = len(sound) - int(sound.sum())
    if not sound.any():
        raise InputError(f"{where} has no points: all {lost:,} are NaN or infinite; export it again")
    first = int((~sound).argmax())
    return cloud.select(sound).remarked(
        f"{counted(lost, 'point')} of {len(sound):,} NaN or infinite, the first is number {first}: dropped"
    )


def lacking_normals(normals: NDArray[np.floating]) -> NDArray[np.bool_]:
    """Which of (n, 3) normals are zero or not finite."""
    with np.errstate(over="ignore", invalid="ignore"):
        length = np.linalg.norm(normals, axis=1)
    return np.asarray(~np.isfinite(length) | (length == 0))


def with_sound_normals(cloud: PointCloud) -> PointCloud:
    """A cloud whose normals are all directions, or that has none.

    A few that are zero or NaN are estimated from those around them (`points.missing_normals`); where more
    than a tenth lack one, none is used, so that one method decides all sides.
    """
    if cloud.normals is None or not len(cloud):
        return replace(cloud, normals=None)
    lacking = lacking_normals(cloud.normals)
    count = int(lacking.sum())
    if not count:
        return cloud
    said = f"{counted(count, 'normal')} of {len(lacking):,} zero or NaN"
    if count == len(lacking):
        return replace(cloud, normals=None)
    if count > MOST_LACKING * len(lacking):
        return replace(cloud, normals=None).remarked(
            f"{said}, more than {100 * MOST_LACKING:.0f} %: none of the given ones is used"
        )
    filled = filled_normals(cloud.points, cloud.normals, lacking)
    return replace(cloud, normals=filled).remarked(f"{said}: estimated from their neighbours")


def check_finite(points: NDArray[np.float64], name: str) -> None:
    """Raise InputError if there are no points, or one is not finite; `name` is for the message."""
    bad = ~np.isfinite(points).all(axis=1)
    if bad.any():
        raise InputError(
            f"{name} has {bad.sum()} points that are NaN or infinite, the first is number {bad.argmax()}; "
            "remove them"
        )
    check_extent(points, name)


def check_extent(points: NDArray[np.float64], name: str) -> None:
    """Raise InputError if there are no points, or one lies beyond what can be computed with."""
    if len(points) == 0:
        raise InputError(f"{name} has no points; give at least one")
    if np.abs(points).max() > LARGEST:
        raise InputError(f"{name} has a coordinate of {np.abs(points).max():.3g}; choose larger units")
