"""Clouds as users hold them (scans, arrays, files, meshes), made ready for matching and drawing."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from datasets_gen import InputError, Shape, as_shape
from medial import Diffusion, Matching
from reports.cli.cloud_files import ThinnedCloud, bare_scan, check_finite, read_cloud, with_normals
from scanner_sim import Scan, sample

ACCEPTED = "a Scan, an (n, 3) array, (points, normals), a path, a Shape or a Diffusion"


@dataclass(frozen=True)
class CloudToMatch:
    """The operator on the points of a cloud that are matched, and how the other points follow them."""

    cloud: ThinnedCloud
    diffusion: Diffusion


def as_cloud(
    given: Any, points: int = 8000, seed: int = 0, name: str = "the cloud", warn: bool = True
) -> Scan:
    """A cloud with normals.

    Parameters
    ----------
    given
        A `Scan`; an (n, 3) array; a pair of points and normals, each (n, 3); the path of a scan, a cloud or a
        mesh; a `Shape` or a ``trimesh.Trimesh``; or a `Diffusion`.
    points, seed
        Number of samples of a mesh, and their seed.
    name
        For messages.
    warn
        Say where normals are estimated.

    Returns
    -------
    Scan
        Without ground truth, unless a scan or a mesh was given: face ids are -1.

    Raises
    ------
    InputError
        If it is none of these, or holds no finite points.
    """
    if isinstance(given, Scan):
        cloud = given
    elif isinstance(given, str | Path):
        return read_cloud(Path(given), points, seed)
    elif isinstance(given, Diffusion):
        cloud = bare_scan(given.points, given.normals, name)
    elif isinstance(given, Shape) or len(getattr(given, "faces", ())):
        cloud = sample(as_shape(given), points, seed)
    else:
        cloud = _from_arrays(given, name)
    check_finite(cloud, name)
    return with_normals(cloud, name, warn)


def _from_arrays(given: Any, name: str) -> Scan:
    """A bare cloud of points, or of a pair of points and normals."""
    pair = isinstance(given, tuple | list) and len(given) == 2
    parts = list(given) if pair else [getattr(given, "vertices", given)]
    arrays = []
    for part in parts:
        try:
            array = np.asarray(part, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise InputError(f"{name} is {type(given).__name__!r}; give {ACCEPTED}") from error
        if array.ndim != 2 or array.shape[1] != 3:
            raise InputError(f"{name} has an array of shape {array.shape}, not (n, 3); give {ACCEPTED}")
        arrays.append(array)
    if pair and len(arrays[0]) != len(arrays[1]):
        raise InputError(
            f"{name} has {len(arrays[0])} points and {len(arrays[1])} normals; give a normal for each point"
        )
    return bare_scan(arrays[0], arrays[1] if pair else None, name)


def prepared(
    given: Any,
    operator: str,
    points: int,
    modes: int,
    seed: int,
    settings: Mapping[str, Any],
    name: str = "the cloud",
) -> CloudToMatch:
    """Thin a cloud out and build its operator; a `Diffusion` is taken as it is.

    Parameters
    ----------
    given, name
        As for `as_cloud`.
    operator, modes, settings
        Of `Diffusion.from_points`.
    points
        Largest number of points to match.
    seed
        Of samples and of the choice of points.
    """
    if isinstance(given, Diffusion):
        cloud = bare_scan(given.points, given.normals, name)
        return CloudToMatch(ThinnedCloud.of(cloud, len(given)), given)
    if points < 1:
        raise InputError(f"cannot match {points!r} points; ask for at least 1")
    thinned = ThinnedCloud.of(as_cloud(given, points, seed, name), points, seed)
    scan = thinned.scan
    return CloudToMatch(
        thinned, Diffusion.from_points(scan.points, scan.normals, operator=operator, modes=modes, **settings)
    )


def prepared_pair(
    source: Any,
    target: Any,
    operator: str,
    points: int,
    modes: int,
    seed: int,
    settings: Mapping[str, Any],
) -> tuple[CloudToMatch, CloudToMatch]:
    """Both clouds of a pair; where one is a `Diffusion`, the other gets its operator and number of modes."""
    for given in (source, target):
        if isinstance(given, Diffusion):
            operator, modes = given.operator, len(given.eigenvalues)
    return (
        prepared(source, operator, points, modes, seed, settings, "the source"),
        prepared(target, operator, points, modes, seed, settings, "the target"),
    )


def extended(found: Matching, source: CloudToMatch, target: CloudToMatch) -> Matching:
    """The map carried from the matched points to all given ones, with the points of both clouds."""
    here, there = source.cloud, target.cloud
    whole = found.extended(here.nearest, here.kept, there.kept)
    return replace(whole, source_points=here.points, target_points=there.points)
