"""Shapes of formulas against the formulas."""

import numpy as np
import pytest

from datasets_gen.bodies import analytic
from datasets_gen.bodies.analytic import CHAIN_LENGTH, RING, SHEET, THICKNESS, TUBE, bend, stretched, varied
from datasets_gen.checks import signed_volume
from datasets_gen.meshes.geometry import face_areas

LINE = np.array([[0, 0, 0], [0, 0.5, 0], [0, 1.0, 0], [0, 1.3, 0]])


def test_a_bent_axis_is_an_arc_and_goes_on_straight():
    """A quarter turn over a length of 1 has the radius 2 / pi; about z it turns y to -x."""
    radius = 2 / np.pi
    found = bend(0, 1, 90)(LINE)
    half = np.sqrt(0.5)
    expected = [
        [0, 0, 0],
        [-radius * (1 - half), radius * half, 0],
        [-radius, radius, 0],
        [-radius - 0.3, radius, 0],
    ]
    assert found == pytest.approx(np.array(expected), abs=1e-5)


def test_slices_of_a_bent_body_stay_flat_and_rigid():
    rng = np.random.default_rng(0)
    points = np.column_stack([rng.uniform(-0.2, 0.2, 30), np.full(30, 0.4), rng.uniform(-0.2, 0.2, 30)])
    found = bend(0, 1, 150, about=analytic.X, twist=90)(points)
    gaps, after = (np.linalg.norm(p[:, None] - p[None], axis=2) for p in (points, found))
    assert after == pytest.approx(gaps, abs=1e-12)
    assert np.linalg.svd(found - found.mean(axis=0), compute_uv=False)[2] == pytest.approx(0, abs=1e-12)


def test_a_wave_ends_as_upright_as_it_began():
    ends = bend(0, 1, 60, waves=2)(np.array([[0, 1.0, 0], [0, 1.2, 0]]))
    assert ends[1] - ends[0] == pytest.approx([0, 0.2, 0], abs=1e-6)


def test_a_twist_turns_the_end():
    assert bend(0, 1, 0, twist=90)(np.array([[0.3, 1.0, 0]])) == pytest.approx(
        np.array([[0, 1, -0.3]]), abs=1e-6
    )


def test_area_and_volume_of_the_torus():
    vertices, faces = analytic.torus_mesh()
    assert face_areas(vertices, faces).sum() == pytest.approx(4 * np.pi**2 * RING * TUBE, rel=2e-3)
    assert signed_volume(vertices, faces) == pytest.approx(2 * np.pi**2 * RING * TUBE**2, rel=4e-3)
    ring = np.hypot(vertices[:, 0], vertices[:, 1]) - RING
    assert np.hypot(ring, vertices[:, 2]) == pytest.approx(TUBE)


def test_volume_of_the_sheet_is_that_of_the_plate_and_half_a_tube_around_it():
    vertices, faces = analytic.sheet_mesh(rim=9)
    width, height = SHEET
    tube = np.pi * (THICKNESS / 2) ** 2 / 2 * 2 * (width + height)
    assert signed_volume(vertices, faces) == pytest.approx(width * height * THICKNESS + tube, rel=3e-3)


@pytest.mark.parametrize("pose", ["roll", "wave", "fold", "roll_askew"])
def test_rolls_keep_the_lengths_of_the_middle_of_the_sheet(pose):
    rng = np.random.default_rng(1)
    middle = np.column_stack([rng.uniform(-0.3, 0.3, 200), rng.uniform(-0.4, 0.4, 200), np.zeros(200)])
    step = 1e-4 * np.column_stack([rng.normal(size=(200, 2)), np.zeros(200)])
    roll = analytic.thin_sheet().poses[pose]
    after = np.linalg.norm(roll(middle + step) - roll(middle), axis=1)
    assert after / np.linalg.norm(step, axis=1) == pytest.approx(1, abs=2e-3)


@pytest.mark.long
@pytest.mark.slow
def test_the_chain_is_a_body_of_revolution_with_these_radii():
    vertices, _ = analytic.capsule_chain().rest()
    radius = np.hypot(vertices[:, 0], vertices[:, 2])
    for at, expected in analytic.CHAIN[1:-1]:
        near = np.abs(vertices[:, 1] - at * CHAIN_LENGTH) < 0.01
        assert np.median(radius[near]) == pytest.approx(expected, abs=0.004)
    assert np.ptp(vertices[:, 1]) == pytest.approx(CHAIN_LENGTH + sum(analytic.CHAIN_CAPS), abs=0.003)


def test_stretching_keeps_the_volume():
    vertices, faces = analytic.torus_mesh()
    assert signed_volume(stretched(vertices, 1.3), faces) == pytest.approx(signed_volume(vertices, faces))


def test_other_subjects_are_within_the_variation_and_differ():
    points = np.random.default_rng(0).uniform(-1, 1, (500, 3))
    found = [varied(points, seed, 0.1) for seed in (1, 2)]
    assert not np.allclose(*found, atol=0.01)
    for each in found:
        ratio = each / points
        assert 0.9 <= ratio.min() < ratio.max() <= 1.1
        assert np.ptp(ratio[:, 1]) == pytest.approx(0, abs=1e-12)
    assert np.array_equal(varied(points, 1, 0.0), points)


def test_a_seed_varies_the_shape_and_keeps_the_mesh():
    (default, faces), (other, same) = analytic.torus().rest(), analytic.torus(5).rest()
    assert np.array_equal(faces, same)
    assert 0.005 < np.abs(other - default).max() < 0.12
