"""Clouds as users hold them (scans, arrays, files, meshes), made ready for matching and drawing."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen import InputError, Shape, as_shape
from datasets_gen.clouds.cleaning import check_finite
from datasets_gen.points.strays import stray_points
from datasets_gen.values import check_count, check_seed, real_array
from medial import Departures, Diffusion, MatchConfig, Matching
from medial.device.backend import CPU
from medial.matching.common_units import SETTINGS
from medial.side_by_side import side_by_side
from reports.cli.cloud_files import ThinnedCloud, bare_scan, read_cloud, with_normals
from scanner_sim import Scan, sample

ACCEPTED = "a Scan, an (n, 3) array, (points, normals), (vertices, faces), a path, a Shape or a Diffusion"
SHARED = (*SETTINGS, "departures")
"""Settings of an operator that both clouds of a pair share."""
SAME = 1e-5
"""Difference of coordinates, over the extent, up to which points are the same: files round."""


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
        mesh; a `Shape`, a ``trimesh.Trimesh`` or (vertices, faces), with faces as integers; or a `Diffusion`.
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
    elif isinstance(given, Shape) or len(getattr(given, "faces", ())) or _is_mesh(given):
        cloud = sample(as_shape(given, strict=False), points, seed)
    else:
        cloud = _from_arrays(given, name)
    check_finite(cloud.points, name)
    return with_normals(cloud, name, warn)


def _is_mesh(given: Any) -> bool:
    """Whether a pair holds vertices and faces; integer normals have no component above 1."""
    if not (isinstance(given, tuple | list) and len(given) == 2):
        return False
    try:
        faces = np.asarray(given[1])
    except ValueError:
        return False
    return bool(faces.ndim == 2 and np.issubdtype(faces.dtype, np.integer) and (faces > 1).any())


def _from_arrays(given: Any, name: str) -> Scan:
    """A bare cloud of points, or of a pair of points and normals."""
    pair = isinstance(given, tuple | list) and len(given) == 2
    parts = list(given) if pair else [getattr(given, "vertices", given)]
    arrays = []
    for part in parts:
        try:
            array = real_array(part, name)
        except InputError as error:
            raise InputError(f"{error}; give {ACCEPTED}") from error
        if array.ndim != 2 or array.shape[1] != 3:
            raise InputError(f"{name} has an array of shape {array.shape}, not (n, 3); give {ACCEPTED}")
        arrays.append(array)
    if pair and len(arrays[0]) != len(arrays[1]):
        raise InputError(
            f"{name} has {len(arrays[0])} points and {len(arrays[1])} normals; give a normal for each point"
        )
    return bare_scan(arrays[0], arrays[1] if pair else None, name)


def check_config(config: Any) -> None:
    """Raise InputError, before operators are built, unless it is something that the matcher takes."""
    MatchConfig.of(config, Departures())


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
    return _with_operator(given, _thinned(given, points, seed, settings, name), operator, modes, settings)


def _thinned(given: Any, points: int, seed: int, settings: Mapping[str, Any], name: str) -> ThinnedCloud:
    """The points that are matched; all of a `Diffusion`, if it has the settings."""
    points, seed = check_count(points, "points"), check_seed(seed)
    if not isinstance(given, Diffusion):
        return ThinnedCloud.of(as_cloud(given, points, seed, name), points, seed, name)
    for key in [each for each in SHARED if each in settings]:
        made, asked = given.parameters.get(key, settings[key]), settings[key]
        if made != asked and (key != "departures" or given.departures != Departures.of(asked)):
            raise InputError(f"{name} is a Diffusion with other {key}; build it with {key}={asked!r}")
    return ThinnedCloud.whole(bare_scan(given.points, given.normals, name))


def _with_operator(
    given: Any, cloud: ThinnedCloud, operator: str, modes: int, settings: Mapping[str, Any]
) -> CloudToMatch:
    if isinstance(given, Diffusion):
        return CloudToMatch(cloud, given)
    points, normals = cloud.scan.points, cloud.scan.normals
    built = Diffusion.from_points(points, normals, operator=operator, modes=modes, **settings)
    return CloudToMatch(cloud, built)


def prepared_pair(
    source: Any,
    target: Any,
    operator: str,
    points: int,
    modes: int,
    seed: int,
    settings: Mapping[str, Any],
) -> tuple[CloudToMatch, CloudToMatch]:
    """Both clouds of a pair; where one is a `Diffusion`, the other gets its operator, modes and settings."""
    for given in (source, target):
        if isinstance(given, Diffusion):
            operator, modes = given.operator, len(given.eigenvalues)
            shared = {key: given.parameters[key] for key in SHARED if key in given.parameters}
            settings = {**shared, **settings}
    here, there = (
        (given, _thinned(given, points, seed, settings, name))
        for given, name in ((source, "the source"), (target, "the target"))
    )

    def made(given: Any, cloud: ThinnedCloud) -> CloudToMatch:
        return _with_operator(given, cloud, operator, modes, settings)

    return side_by_side(made, here, there, settings.get("device", CPU))


def check_pair(found: Matching, source: Scan, target: Scan) -> None:
    """Raise InputError unless a map goes from one cloud to another, as far as it can be told."""
    ids = found.source_to_target if isinstance(found, Matching) else None
    if not isinstance(ids, np.ndarray) or ids.dtype.kind not in "iu" or ids.ndim != 1:
        what = type(found).__name__ if ids is None else "Matching without a column of integer ids"
        raise InputError(
            f"a {what} is no map; give what match() returns, or evaluation.methods.dense(ids, confidence)"
        )
    if len(source) != len(found):
        raise InputError(f"the map does not fit: it has {len(found)} source points, the source {len(source)}")
    if len(found) and found.source_to_target.max() >= len(target):
        last = found.source_to_target.max()
        raise InputError(f"the map does not fit: it names target point {last}, the target has {len(target)}")
    sure = np.asarray(found.confidence)
    if sure.shape != ids.shape or not ((sure >= 0) & (sure <= 1)).all():
        raise InputError("the map needs a confidence in [0, 1] for every source point, none of them NaN")
    check_matched(found.source_points, source, "source")
    check_matched(found.target_points, target, "target")


def check_matched(held: NDArray[np.float64] | None, given: Scan, name: str) -> None:
    """Raise InputError if the points that a map holds of a side are not those of a cloud."""
    there = given.points
    if held is not None and not (
        held.shape == there.shape and np.allclose(held, there, 0, SAME * _extent(held))
    ):
        raise InputError(
            f"the map was made of another {name}: its points are not those of the one given; "
            "give the clouds that were matched, the source first"
        )


def _extent(points: NDArray[np.float64]) -> float:
    """Extent of a cloud without its strays; 0 of an empty one."""
    return float(np.ptp(points[~stray_points(points)])) if len(points) else 0.0


def extended(found: Matching, source: CloudToMatch, target: CloudToMatch) -> Matching:
    """The map carried from the matched points to all given ones, with the points of both clouds."""
    here, there = source.cloud, target.cloud
    whole = found.extended(here.nearest, here.kept, there.kept, here.stray)
    return replace(whole, source_points=here.points, target_points=there.points)
