"""What a sound object is, for every type that a reader gives; each raises AssertionError where it is not."""

import math

import numpy as np

from datasets_gen import Collection, Shape
from medial import Diffusion, Matching
from scanner_sim import Scan


def sound_shape(shape: Shape) -> None:
    assert isinstance(shape, Shape)
    vertices, faces = shape.vertices, shape.faces
    assert vertices.dtype.kind == "f", vertices.dtype
    assert vertices.ndim == 2, vertices.shape
    assert vertices.shape[1] == 3, vertices.shape
    assert faces.dtype in (np.int32, np.int64), (faces.dtype, faces.shape)
    assert faces.ndim == 2, (faces.dtype, faces.shape)
    assert faces.shape[1] == 3, (faces.dtype, faces.shape)
    assert len(faces), "faces out of range"
    assert faces.min() >= 0, "faces out of range"
    assert faces.max() < len(vertices), "faces out of range"
    assert np.isfinite(vertices[faces]).all(), "vertices not finite"
    assert all(isinstance(t, str) for t in (shape.name, shape.subject, shape.pose, shape.units)), "names"


def sound_shapes(found: Collection) -> None:
    """For frames, each of which has faces of its own."""
    assert isinstance(found, Collection)
    for shape in found.shapes:
        sound_shape(shape)


def sound_collection(found: Collection) -> None:
    assert isinstance(found, Collection)
    for shape in (found.reference, *found.shapes):
        sound_shape(shape)
        assert shape.vertices.shape == found.reference.vertices.shape
    if found.mirror is not None:
        count = len(found.reference.vertices)
        assert found.mirror.shape == (count,), "mirror"
        assert found.mirror.dtype.kind in "iu", "mirror"
        assert found.mirror.min() >= 0, "mirror out of range"
        assert found.mirror.max() < count, "mirror out of range"


def sound_scan(scan: Scan) -> None:
    assert isinstance(scan, Scan)
    n = len(scan)
    _numbers(scan, "points normals true_points barycentrics", (n, 3), "f")
    _numbers(scan, "intensity width angle", (n,), "f")
    _numbers(scan, "face_ids view_ids", (n,), "iu")
    _numbers(scan, "pixels", (n, 2), "iu")
    assert scan.poses.ndim == 3, "poses"
    assert scan.poses.shape[1:] == (4, 4), "poses"
    assert scan.poses.dtype.kind == "f", "poses"
    assert np.isfinite(scan.points).all(), "points not finite"
    assert isinstance(scan.shape_name, str), "metadata"
    assert isinstance(scan.seed, int), "metadata"
    assert isinstance(scan.scale, int | float), "scale"
    assert math.isfinite(scan.scale), "scale"


def sound_cloud(scan: Scan) -> None:
    sound_scan(scan)
    assert len(scan) > 0, "empty"
    # Normals that are NaN are refused where an operator is built.


def sound_diffusion(found: Diffusion) -> None:
    assert isinstance(found, Diffusion)
    n, modes = len(found.points), len(found.eigenvalues)
    _numbers(found, "points normals centers", (n, 3), "f")
    _numbers(found, "areas radii", (n,), "f")
    _numbers(found, "eigenvalues", (modes,), "f")
    _numbers(found, "eigenfunctions", (n, modes), "f")
    for name in ("points", "areas", "eigenvalues", "eigenfunctions"):
        assert np.isfinite(getattr(found, name)).all(), f"{name} not finite"


def sound_matching(found: Matching) -> None:
    assert isinstance(found, Matching)
    n = len(found)
    _numbers(found, "source_to_target", (n,), "iu")
    _numbers(found, "confidence", (n,), "f")
    _numbers(found, "landmarks", (len(found.landmarks), 2), "iu")
    assert found.source_to_target.min(initial=0) >= -1, "ids below -1"
    assert ((found.confidence >= 0) & (found.confidence <= 1)).all(), "confidence outside [0, 1]"
    for name, ids in (("source_points", np.arange(n)), ("target_points", found.source_to_target)):
        points = getattr(found, name)
        if points is not None:
            assert points.ndim == 2, name
            assert points.shape[1] == 3, name
            assert points.dtype.kind == "f", name
            assert ids.max(initial=-1) < len(points), f"ids beyond {name}"


def _numbers(record, names, shape, kinds) -> None:
    for name in names.split():
        array = getattr(record, name)
        assert isinstance(array, np.ndarray), f"{name} is {type(array).__name__}"
        assert array.shape == shape, f"{name} has shape {array.shape}, not {shape}"
        assert array.dtype.kind in kinds, f"{name} is {array.dtype}"


def sound_ids(found) -> None:
    """Of correspondences that another program made."""
    assert found.ids.dtype == np.int64
    assert found.ids.ndim == 1
    for array, shape in ((found.confidence, (len(found),)), (found.weights, (len(found), 3))):
        assert array is None or (array.dtype == np.float64 and array.shape == shape)
