import numpy as np
import pytest
import trimesh

from datasets_gen.meshes.geometry import (
    face_areas,
    face_normals,
    scaled_face_normals,
    unit_vectors,
    vertex_normals,
    winding_number,
)
from tests.datasets_gen.sample_meshes import box, shuffled, sphere


def irregular():
    mesh = shuffled(sphere(2))
    return mesh.vertices * [1.0, 2.0, 0.5], mesh.faces


def test_scaled_face_normals_are_twice_the_area_and_outward():
    mesh = box()
    normals = scaled_face_normals(mesh.vertices, mesh.faces)
    assert np.linalg.norm(normals, axis=1) == pytest.approx(2 * mesh.face_areas)
    assert (np.einsum("nd,nd->n", normals, mesh.vertices[mesh.faces].mean(axis=1)) > 0).all()


def test_normals_and_areas_agree_with_trimesh():
    vertices, faces = irregular()
    slow = trimesh.Trimesh(vertices, faces, process=False)
    assert face_normals(vertices, faces) == pytest.approx(slow.face_normals)
    assert face_areas(vertices, faces) == pytest.approx(slow.area_faces)
    by_angle = trimesh.geometry.weighted_vertex_normals(
        len(vertices), faces, slow.face_normals, slow.face_angles
    )
    assert vertex_normals(vertices, faces) == pytest.approx(by_angle)
    by_area = trimesh.geometry.mean_vertex_normals(len(vertices), faces, scaled_face_normals(vertices, faces))
    assert vertex_normals(vertices, faces, "area") == pytest.approx(by_area)


def test_angle_weights_do_not_see_the_triangulation():
    """Every corner of a box has three perpendicular sides, whatever their diagonals."""
    mesh = box()
    assert vertex_normals(mesh.vertices, mesh.faces) == pytest.approx(unit_vectors(mesh.vertices))
    assert vertex_normals(mesh.vertices, mesh.faces, "area") != pytest.approx(unit_vectors(mesh.vertices))


@pytest.mark.parametrize("weighting", ["angle", "area"])
def test_normals_of_a_sphere_are_its_points(weighting):
    mesh = sphere(3)
    found = vertex_normals(mesh.vertices, mesh.faces, weighting)
    assert np.einsum("nd,nd->n", found, mesh.vertices).min() > 0.999


@pytest.mark.parametrize("weighting", ["angle", "area"])
def test_no_area_and_no_faces_give_zero(weighting):
    vertices = np.array([[0.0, 0, 0], [1, 0, 0], [2, 0, 0], [9, 9, 9]])
    faces = np.array([[0, 1, 2]])
    assert (face_normals(vertices, faces) == 0).all()
    assert (vertex_normals(vertices, faces, weighting) == 0).all()


def test_winding_number_is_one_inside_and_zero_outside():
    mesh = sphere(2)
    corners = mesh.vertices[mesh.faces]
    assert winding_number(corners, np.array([0.2, 0.1, -0.3])) == pytest.approx(1)
    assert winding_number(corners[:, ::-1], np.zeros(3)) == pytest.approx(-1)
    assert winding_number(corners, np.array([2.0, 0, 0])) == pytest.approx(0, abs=1e-12)
