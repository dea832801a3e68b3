import logging
from dataclasses import replace

import numpy as np
import pytest

from datasets_gen import InputError, check_mesh
from datasets_gen.checks import (
    admitted,
    edge_face_counts,
    face_components,
    looks_inward,
    oriented,
    repaired,
    scannable,
    signed_volume,
    winding_conflicts,
)
from tests.datasets_gen.sample_meshes import box, shape, sphere


def two_spheres():
    a, b = sphere(1), sphere(2)
    vertices = np.concatenate([a.vertices, b.vertices + np.array([5.0, 0, 0])])
    return shape(vertices, np.concatenate([a.faces, b.faces + len(a.vertices)]), "pair")


def with_coordinate(value):
    vertices = box().vertices.copy()
    vertices[3, 1] = value
    return shape(vertices, box().faces)


def with_face(*face):
    mesh = sphere(1)
    return shape(mesh.vertices, np.concatenate([mesh.faces, [face]]))


def collapsed_vertex():
    mesh = sphere(1)
    vertices = mesh.vertices.copy()
    vertices[mesh.faces[0, 0]] = vertices[mesh.faces[0, 1]]
    return shape(vertices, mesh.faces)


def fin():
    mesh = sphere(1)
    a, b, _ = mesh.faces[0]
    vertices = np.concatenate([mesh.vertices, [[0, 0, 3.0]]])
    return shape(vertices, np.concatenate([mesh.faces, [[a, b, len(mesh.vertices)]]]))


def one_face_turned():
    faces = sphere(1).faces.copy()
    faces[5] = faces[5, ::-1]
    return shape(sphere(1).vertices, faces)


def moebius():
    n = 12
    angle = np.linspace(0, 2 * np.pi, n, endpoint=False)
    rim = []
    for s in (-0.3, 0.3):
        radius = 1 + s * np.cos(angle / 2)
        rim.append(np.stack([radius * np.cos(angle), radius * np.sin(angle), s * np.sin(angle / 2)], axis=1))
    faces = []
    for i in range(n):
        a, b, c, d = i, n + i, (i + 1) % n, n + (i + 1) % n
        if i == n - 1:
            c, d = n, 0
        faces += [[a, b, c], [b, d, c]]
    return shape(np.concatenate(rim), faces)


@pytest.mark.parametrize("mesh", [box(), sphere(2)])
def test_sound_meshes_pass_without_a_remark(mesh):
    assert check_mesh(mesh) == ()


@pytest.mark.parametrize(
    ("mesh", "reason"),
    [
        (with_coordinate(np.nan), "NaN or infinite"),
        (with_coordinate(np.inf), "NaN or infinite"),
        (shape(box().vertices, np.empty((0, 3))), "no faces"),
        (with_face(0, 1, 9999), "vertex 9999"),
        (with_face(0, -1, 2), "vertex -1"),
        (with_face(0, 1, 1), "degenerate"),
        (collapsed_vertex(), "degenerate"),
        (fin(), r"1 non-manifold edges \(more than two faces\), one between vertices \d+ and \d+; clean it"),
        (two_spheres(), "2 components"),
        (one_face_turned(), "not orientable"),
    ],
)
def test_unusable_meshes_are_refused_in_one_line(mesh, reason):
    with pytest.raises(InputError, match=reason) as caught:
        check_mesh(mesh)
    assert "\n" not in str(caught.value)
    assert mesh.name in str(caught.value)


def test_open_boundary_unused_vertices_and_inward_faces_are_remarks():
    mesh = sphere(2)
    holed = shape(np.concatenate([mesh.vertices, [[9.0, 9, 9]]]), mesh.faces[3:])
    assert len(check_mesh(holed)) == 2
    assert "open boundary" in check_mesh(holed)[0]
    assert check_mesh(shape(mesh.vertices, mesh.faces[:, ::-1])) == ("faces look inward",)


def test_inward_faces_are_flipped_with_a_line_in_the_log(caplog):
    mesh = sphere(2)
    with caplog.at_level(logging.WARNING):
        (fixed,) = admitted([replace(mesh, faces=np.ascontiguousarray(mesh.faces[:, ::-1]))])
    assert signed_volume(fixed.vertices, fixed.faces) > 0
    assert "looked inward; flipped" in caplog.text
    assert (np.sort(fixed.faces, axis=1) == np.sort(mesh.faces, axis=1)).all()  # same faces in the same order


def test_faces_wound_against_each_other_are_made_consistent(caplog):
    mesh = one_face_turned()
    with caplog.at_level(logging.WARNING):
        (fixed,) = admitted([mesh])
    assert winding_conflicts(fixed.faces) == 0
    assert signed_volume(fixed.vertices, fixed.faces) > 0
    assert "made consistent" in caplog.text
    assert (np.sort(fixed.faces, axis=1) == np.sort(mesh.faces, axis=1)).all()


def test_a_moebius_strip_cannot_be_oriented():
    with pytest.raises(InputError, match="not orientable"):
        admitted([moebius()])


def test_flipping_follows_the_first_pose_and_applies_to_all():
    mesh = sphere(1)
    inward = np.ascontiguousarray(mesh.faces[:, ::-1])
    poses = [replace(mesh, faces=inward, pose=p, vertices=mesh.vertices * s) for p, s in (("a", 1), ("b", 2))]
    first, second = admitted(poses)
    assert np.array_equal(first.faces, second.faces)
    assert signed_volume(second.vertices, second.faces) > 0


def test_sound_faces_are_left_alone():
    mesh = sphere(2)
    assert oriented(mesh.faces, mesh.vertices, "m") is mesh.faces


def test_repair_keeps_the_largest_part_in_every_pose(caplog):
    mesh = two_spheres()
    other = replace(mesh, pose="b", vertices=mesh.vertices * 2)
    with caplog.at_level(logging.WARNING):
        first, second = admitted([mesh, other], repair=True)
    assert len(first.vertices) == len(sphere(2).vertices)
    assert np.array_equal(first.faces, second.faces)
    assert second.vertices == pytest.approx(2 * first.vertices)
    assert "kept" in caplog.text


def test_repair_drops_degenerate_and_repeated_faces():
    mesh = sphere(1)
    faces = np.concatenate([mesh.faces, [[0, 1, 1]], mesh.faces[:1, [1, 2, 0]]])
    (fixed,) = admitted([shape(mesh.vertices, faces)], repair=True)
    assert check_mesh(fixed) == ()
    assert len(fixed.faces) == len(mesh.faces)


def test_repair_leaves_a_sound_mesh_alone():
    meshes = [sphere(1)]
    assert repaired(meshes) is meshes


def test_repair_tolerates_a_face_that_is_flat_in_one_pose(caplog):
    flat = collapsed_vertex()
    rest = sphere(1)
    with caplog.at_level(logging.WARNING):
        first, second = admitted([replace(rest, name=flat.name), flat], repair=True)
    assert len(second.faces) == len(first.faces) == len(rest.faces)
    assert "faces have no area" in caplog.text


def test_repair_refuses_a_mesh_with_nothing_left():
    with pytest.raises(InputError, match="only degenerate"):
        admitted([shape([[0, 0, 0], [1, 0, 0], [2, 0, 0]], [[0, 1, 2]])], repair=True)


def test_counts_on_known_meshes():
    assert (edge_face_counts(box().faces) == 2).all()
    assert len(edge_face_counts(box().faces)) == 18
    assert len(np.unique(face_components(two_spheres().faces))) == 2
    assert signed_volume(box().vertices + 7, box().faces) == pytest.approx(1)


def test_closed_bodies_look_inward_or_not_and_reliefs_never_do():
    """Half a sphere's normals sum to half its area; the faces of a sheet to all of theirs."""
    ball = sphere(3)
    inside_out = ball.faces[:, ::-1]
    assert not looks_inward(ball.vertices, ball.faces)
    assert looks_inward(ball.vertices, inside_out)
    assert looks_inward(ball.vertices, inside_out[3:])  # a hole of three faces
    bowl = inside_out[ball.vertices[ball.faces].mean(axis=1)[:, 2] < 0]
    assert signed_volume(ball.vertices, bowl) < 0
    assert not looks_inward(ball.vertices, bowl)
    assert np.array_equal(oriented(bowl, ball.vertices, "bowl"), bowl)


@pytest.mark.parametrize("mesh", [two_spheres(), with_face(0, 0, 1), with_face(0, 1, 2), sphere(2)])
def test_meshes_with_a_surface_can_be_scanned_as_they_are(mesh):
    assert scannable(mesh) is mesh


def test_meshes_to_scan_are_wound_as_others_are(caplog):
    mesh = sphere(1)
    turned = shape(mesh.vertices, mesh.faces[:, ::-1])
    with caplog.at_level(logging.WARNING):
        assert np.array_equal(scannable(turned).faces, admitted([turned])[0].faces)
    assert "looked inward" in caplog.text


def test_meshes_without_a_surface_cannot_be_scanned():
    with pytest.raises(InputError, match="NaN"):
        scannable(with_coordinate(np.nan))
    with pytest.raises(InputError, match="vertex 99"):
        scannable(with_face(0, 1, 99))
    with pytest.raises(InputError, match="degenerate"):
        scannable(shape(np.eye(3), [[0, 0, 1]]))
    with pytest.raises(InputError, match="no faces"):
        scannable(shape(np.eye(3), np.empty((0, 3))))


def test_repair_keeps_the_largest_part_to_scan():
    assert len(scannable(two_spheres(), repair=True).vertices) == len(sphere(2).vertices)
