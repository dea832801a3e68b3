"""Mirror images of points of symmetric meshes."""

import numpy as np
import pytest

from evaluation.metrics.correspondence import SurfacePoints
from evaluation.metrics.mirror_images import _faces_of_vertices, mirror_points
from tests.evaluation.meshes import as_shape, plane, random_points, sphere

pytestmark = pytest.mark.uncompiled


def test_faces_around_each_vertex():
    shape = plane(4)  # 1 to 6 faces at a vertex
    found = _faces_of_vertices(shape)
    for v, row in enumerate(found):
        around = np.flatnonzero((shape.faces == v).any(axis=1)).tolist()
        assert row[: len(around)].tolist() == around
        assert (row[len(around) :] == -1).all()
    assert found.shape[1] == max((shape.faces == v).sum() for v in range(16))


def test_mirror_images_lie_on_the_other_side():
    """An icosphere is its own image under x -> -x, mesh and all."""
    ball = sphere(1)
    shape = as_shape(ball.vertices * [1, 0.5, 0.7], ball.faces)
    reflected = shape.vertices * [-1, 1, 1]
    mirror = np.linalg.norm(shape.vertices[:, None] - reflected, axis=2).argmin(axis=0)
    cloud = SurfacePoints(*random_points(shape, 60))
    image = mirror_points(shape, mirror, cloud)
    assert image.on(shape) == pytest.approx(cloud.on(shape) * [-1, 1, 1], abs=1e-9)
    assert image.barycentrics.sum(axis=1) == pytest.approx(np.ones(60))
    assert (image.barycentrics >= 0).all()


def test_where_the_mesh_is_not_symmetric_the_closest_place_around_is_taken():
    """A square cut along one diagonal is mirrored to one cut along the other."""
    corners = np.array([[0.0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]])
    shape = as_shape(corners, [[0, 1, 2], [0, 2, 3]])
    mirror = np.array([1, 0, 3, 2])
    cloud = SurfacePoints(*random_points(shape, 40))
    found = mirror_points(shape, mirror, cloud).on(shape)
    assert found == pytest.approx(cloud.on(shape) * [-1, 1, 1] + [1, 0, 0], abs=1e-12)
