"""Contact sheets of poses: surfaces are covered whatever the sizes of their faces."""

import numpy as np
import trimesh
from scipy.spatial import cKDTree

from reports.figures.pose_sheet import surface_points
from tests.datasets_gen.sample_meshes import shape


def test_large_faces_are_covered_as_densely_as_small_ones():
    """A box of 12 faces beside a sphere of 5,120: no place is further than two spacings from a point."""
    ball = trimesh.creation.icosphere(subdivisions=4).apply_translation([5, 0, 0])
    both = trimesh.util.concatenate([trimesh.creation.box(extents=[2, 2, 2]), ball])
    points, normals = surface_points(shape(both.vertices, both.faces), 10_000)
    assert 10_000 <= len(points) <= 30_000
    assert np.allclose(np.linalg.norm(normals, axis=1), 1)
    probes, _ = trimesh.sample.sample_surface(both, 5000, seed=0)
    spacing = np.sqrt(both.area / 10_000)
    assert cKDTree(points).query(probes)[0].max() < 2 * spacing


def test_points_lie_on_the_surface():
    ball = trimesh.creation.icosphere(subdivisions=2)
    points, normals = surface_points(shape(ball.vertices, ball.faces), 1000)
    heights = np.einsum("nfd,fd->nf", points[:, None] - ball.triangles[:, 0], ball.face_normals)
    assert np.abs(heights.max(axis=1)).max() < 1e-9  # a convex body is where no plane is above
    assert np.einsum("nd,nd->n", points, normals).min() > 0.9
