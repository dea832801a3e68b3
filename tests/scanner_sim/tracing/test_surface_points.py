"""Normals at creases and at silhouettes."""

import numpy as np
import pytest
import trimesh

from datasets_gen.meshes.geometry import face_normals, vertex_normals
from scanner_sim import ScannerConfig, coverage, scan
from scanner_sim.tracing import surface_points
from scanner_sim.tracing.mitsuba_mesh import split_vertices
from scanner_sim.tracing.surface_points import bent_normals, corner_normals
from tests.scanner_sim.conftest import to_shape

BOX = to_shape(trimesh.creation.box((75.0, 75.0, 75.0)))


def facets(shape):
    return np.repeat(face_normals(shape.vertices, shape.faces)[:, None], 3, axis=1)


def test_a_cube_has_flat_sides_whatever_its_diagonals():
    assert corner_normals(BOX, "smooth") == pytest.approx(facets(BOX), abs=1e-12)
    assert corner_normals(BOX, "flat") == pytest.approx(facets(BOX), abs=1e-12)


def test_meshes_without_creases_have_the_normals_of_their_vertices_to_the_bit(sphere):
    """Edges of a fine sphere turn by some degrees, those of an icosahedron by 41.8."""
    for shape in (sphere, to_shape(trimesh.creation.icosahedron())):
        assert np.array_equal(
            corner_normals(shape, "smooth"), vertex_normals(shape.vertices, shape.faces)[shape.faces]
        )


@pytest.mark.parametrize(("angle", "sharp"), [(89.99, True), (90.0, False), (180.0, False), (0.0, True)])
def test_the_crease_angle_is_the_largest_turn_of_a_smooth_edge(angle, sharp):
    """Edges of a box turn by 90 degrees; where they are smooth, the normals of a corner point outward."""
    found = corner_normals(BOX, "smooth", angle)
    wanted = facets(BOX) if sharp else vertex_normals(BOX.vertices, BOX.faces)[BOX.faces]
    assert found == pytest.approx(wanted, abs=1e-12)


def test_the_side_of_a_cylinder_stays_round_at_its_rim(cylinder):
    """Normals of the side are radial; those of a mesh without creases lean over the rim by 45 degrees."""
    normals, faces = corner_normals(cylinder, "smooth"), cylinder.faces
    side = np.abs(face_normals(cylinder.vertices, faces)[:, 1]) < 0.5
    radial = cylinder.vertices[faces[side]] * [1, 0, 1]
    radial /= np.linalg.norm(radial, axis=2, keepdims=True)
    assert np.einsum("fcd,fcd->fc", normals[side], radial).min() > np.cos(np.radians(0.51))  # a facet is 0.5
    assert np.abs(normals[~side][..., 1]) == pytest.approx(1)


def test_creases_do_not_depend_on_how_many_corners_are_compared_at_a_time(cylinder, monkeypatch):
    whole = corner_normals(cylinder, "smooth")
    monkeypatch.setattr(surface_points, "PAIRS", 100)
    assert np.array_equal(corner_normals(cylinder, "smooth"), whole)


def test_split_vertices_have_one_normal_each():
    normals = np.round(corner_normals(BOX, "smooth"), 9)
    source, faces = split_vertices(BOX.faces, normals)
    assert len(source) == 24  # three sides meet at each of eight corners
    assert np.array_equal(source[:8], np.arange(8))
    assert np.array_equal(source[faces], BOX.faces)
    given = np.zeros((24, 3))
    given[faces] = normals
    assert np.array_equal(given[faces], normals)


def test_a_smooth_cube_is_scanned_as_a_flat_one(each_variant):
    settings = {"views": 4, "resolution": (80, 80)}
    smooth, flat, round_ = (
        scan(BOX, ScannerConfig(**settings, **more))
        for more in ({}, {"shading": "flat"}, {"crease_angle": 180.0})
    )
    assert np.array_equal(smooth.points, flat.points)
    assert smooth.normals == pytest.approx(flat.normals, abs=1e-9)
    assert len(round_) < 0.97 * len(smooth)
    assert coverage(smooth, BOX) > coverage(round_, BOX)


def test_attributes_and_textures_follow_split_vertices(each_variant):
    """A cube, black on its left half by vertex: the right corners are white, so albedo is x / 75 + 1 / 2."""
    albedo = BOX.vertices[:, 0] / 75 + 0.5
    config = ScannerConfig(
        views=((0, 0, 1),), resolution=(60, 60), material="vertex_albedo", bits=0, fit="least_squares"
    )
    found = scan(BOX, config, attributes={"vertex_albedo": albedo})
    white = scan(BOX, ScannerConfig(views=((0, 0, 1),), resolution=(60, 60), bits=0, fit="least_squares"))
    keys = [scan.pixels[:, 0] + 60 * scan.pixels[:, 1] for scan in (white, found)]
    _, here, there = np.intersect1d(*keys, return_indices=True)
    ratio = found.intensity[there] / white.intensity[here]
    assert len(here) > 500
    assert ratio == pytest.approx(white.true_points[here, 0] / 75 + 0.5, abs=2e-3)


def test_bent_normals_are_those_of_the_faces_where_only_these_face_camera_and_laser():
    up, left, down = np.eye(3)[2], -np.eye(3)[0], -np.eye(3)[2]
    shading, geometric = np.array([down, down, up, left]), np.array([up, down, left, up])
    eye = np.array([[0.1, 0, 1]] * 4)
    found, bent = bent_normals(shading, geometric, eye, eye + np.array([0, 0.1, 0]))
    assert bent.tolist() == [True, False, False, True]
    assert np.array_equal(found, np.array([up, down, up, up]))
