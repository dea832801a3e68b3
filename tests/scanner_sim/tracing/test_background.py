"""A plane behind the object, and objects that shadow each other, against analytic geometry."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from datasets_gen import Shape
from scanner_sim import ScannerConfig, scan
from scanner_sim.optics.verdict import Verdict
from scanner_sim.scanner import Rig
from scanner_sim.tracing import background

FRONT = {"views": ((0, 0, 1),), "resolution": (80, 80)}


def view(shape, **settings):
    rig = Rig(shape, ScannerConfig(**(FRONT | settings)))
    return rig, *rig.view(0, 0)


def mean_radiance(hits, columns):
    number = hits.pixels[:, 1] * columns + hits.pixels[:, 0]
    counts = np.bincount(number)
    return np.bincount(number, hits.radiance)[counts > 0] / counts[counts > 0], counts


def test_the_plane_stands_behind_the_centre(sphere, each_variant):
    """At min_range + half the diagonal + the distance from the centre, square to the view; white."""
    rig, hits, _ = view(sphere, footprint=3, background=60.0)
    plane = hits.face_ids == background.FACE
    depth = 70 + rig.tracer.frame.diagonal / 2 + 60
    assert plane.any()
    assert np.allclose(hits.points[plane, 2], depth)
    assert np.allclose(hits.normals[plane], [0, 0, -1])
    toward = np.array([50.0, 0, 0]) - hits.points[plane]
    lit = hits.radiance[plane] > 0
    assert np.allclose(hits.radiance[plane][lit], (depth / np.linalg.norm(toward, axis=1))[lit])


def test_the_sphere_shadows_the_plane(sphere, each_variant):
    """The way from a shadowed point to the laser passes the centre nearer than the radius."""
    _, hits, _ = view(sphere, footprint=5, background=60.0)
    plane = hits.face_ids == background.FACE
    points, laser = hits.points[plane], np.array([50.0, 0, 0])
    centre = np.array([0, 0, hits.points[plane][0, 2] - 60])
    way = (laser - points) / np.linalg.norm(laser - points, axis=1, keepdims=True)
    across = (centre - points) - ((centre - points) * way).sum(axis=1, keepdims=True) * way
    passing = np.linalg.norm(across, axis=1)
    dark = hits.radiance[plane] == 0
    assert dark.mean() > 0.1
    assert (passing[dark] < 37.5).all()
    assert (passing[~dark] > 37.5 * np.cos(np.pi / 160)).all()  # inside of its facets


def test_every_ray_of_a_mixed_pixel_hits_something(sphere):
    _, hits, _ = view(sphere, footprint=3, background=60.0)
    _, counts = mean_radiance(hits, 80)
    assert set(np.unique(counts)) == {0, 9}
    _, alone, _ = view(sphere, footprint=3)
    assert np.array_equal(np.unique(hits.pixels, axis=0), np.unique(alone.pixels, axis=0))


def test_points_of_the_plane_are_dropped(sphere):
    """With a footprint of one ray nothing mixes, so nothing changes."""
    config = ScannerConfig(**FRONT)
    with_plane = scan(sphere, replace(config, background=60.0))
    assert np.array_equal(with_plane.points, scan(sphere, config).points)
    wide = scan(sphere, replace(config, background=60.0, footprint=3))
    assert (wide.face_ids >= 0).all()


def test_blurred_light_of_the_plane_reaches_its_neighbours(sphere):
    _, hits, measured = view(sphere, background=45.0, smoothing=1.0)
    plane = hits.face_ids == background.FACE
    shown = np.unique(hits.pixels[~plane], axis=0)
    gap = np.abs(hits.pixels[plane][:, None] - shown).max(axis=2).min(axis=1)
    assert gap.min() == 1
    assert gap.max() == 3
    of_plane = hits.face_ids[measured.index] == background.FACE
    assert of_plane.any()
    assert (measured.verdict[of_plane] == Verdict.MISS).all()


def test_the_back_of_an_open_mesh_hides_the_plane():
    """A plate that looks away is not seen but still in the way."""
    plate = trimesh.creation.box((40.0, 40.0, 1.0))
    faces = plate.faces[plate.face_normals[:, 2] < -0.5]
    post = trimesh.creation.box((4.0, 75.0, 4.0))
    post.apply_translation([0, 0, -30])
    vertices = np.concatenate([plate.vertices, post.vertices])
    shape = Shape(vertices, np.concatenate([faces, post.faces + 8]).astype(np.int32), "x", "x", "x", "mm")
    _, hits, _ = view(shape, footprint=1, background=60.0, smoothing=1.0)
    plane = hits.points[hits.face_ids == background.FACE]
    centre = plane[0, 2] - 60
    inside = (np.abs(plane[:, :2]) / plane[0, 2] * centre < 17).all(axis=1)
    assert not inside.any()


def test_one_of_two_objects_shadows_the_other():
    """A wall beside a sheet: on the sheet, the wall's shadow ends where the laser's ray passes its top edge.

    In camera coordinates at (x, 0, z): the laser at (50, 0, 0), the sheet at the depth D, the wall's top edge
    at x = w and the depth T. The shadow reaches from the wall to w - (50 - w) (D - T) / T.
    """
    sheet = trimesh.creation.box((75.0, 75.0, 1.0))
    wall = trimesh.creation.box((1.0, 75.0, 20.0))
    wall.apply_translation([10, 0, 14.5])
    both = trimesh.util.concatenate([sheet, wall])
    shape = Shape(np.asarray(both.vertices), both.faces.astype(np.int32), "two", "two", "two", "mm")
    rig, hits, _ = view(shape, resolution=(200, 200))
    on_sheet = np.isclose(hits.normals[:, 2], -1) & (hits.face_ids < len(sheet.faces))
    row = on_sheet & (np.abs(hits.points[:, 1]) < 20)
    points, dark = hits.points[row], hits.radiance[row] == 0
    sheet_depth = float(np.median(points[:, 2]))
    top = sheet_depth - 24
    edge = 9.5 - (50 - 9.5) * (sheet_depth - top) / top
    near_side = points[:, 0] < 9.5
    pitch = sheet_depth / rig.config.focal
    assert points[near_side & dark, 0].min() == pytest.approx(edge, abs=1.5 * pitch)
    assert dark[near_side & (points[:, 0] > edge + pitch)].all()
    assert not dark[points[:, 0] < edge - pitch].any()
