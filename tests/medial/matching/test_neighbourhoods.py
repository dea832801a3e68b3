"""Coordinates in which pieces of limbs are close."""

from dataclasses import replace

import numpy as np
import pytest

from medial.matching.landmarks.samples import diffusion_map
from medial.matching.neighbourhoods import TIME, neighbourhoods, piece_radius
from medial.spectrum.times import shortest_time
from tests.medial.clouds import rotation
from tests.medial.posed import figure


def distances(coordinates, ids):
    return np.linalg.norm(coordinates[ids][:, None] - coordinates[ids], axis=2)


def test_units_motion_and_pose_of_the_frame_do_not_matter():
    ids = np.arange(0, len(figure()), 40)
    before = distances(neighbourhoods(figure()), ids)
    scale = 1000.0
    moved = replace(
        figure(),
        points=scale * figure().points @ rotation(3).T + [5.0, -2.0, 9.0],
        eigenvalues=figure().eigenvalues / scale**2,
        eigenfunctions=figure().eigenfunctions / scale,
        areas=figure().areas * scale**2,
    )
    assert np.allclose(distances(neighbourhoods(moved), ids), before, rtol=1e-3, atol=1e-3)


def test_modes_that_are_left_out_change_no_distance():
    cloud, ids = figure(), np.arange(0, len(figure()), 20)
    time = TIME * shortest_time(cloud.eigenvalues)
    found, every = neighbourhoods(cloud)[:, :-3], diffusion_map(cloud, time).astype(np.float32)
    assert found.shape[1] < every.shape[1]
    assert np.allclose(
        distances(found, ids), distances(every / piece_radius(every), ids), rtol=1e-5, atol=1e-5
    )


def test_limbs_that_diffusion_takes_for_one_stay_apart():
    """An empty ball may span two legs whose inner sides were not seen: then all its modes agree there."""
    cloud = figure()
    merged = replace(cloud, eigenfunctions=np.repeat(cloud.eigenfunctions[:1], len(cloud), axis=0))
    merged.eigenfunctions[:10, 1] += 1.0  # tells some points apart, but not left from right
    hand = int(cloud.points[:, 0].argmax()), int(cloud.points[:, 0].argmin())
    apart = np.linalg.norm(np.subtract(*neighbourhoods(merged)[list(hand)]))
    assert apart > 3


def test_pieces_count_alike_in_diffusion_and_in_space():
    coordinates = neighbourhoods(figure())
    assert piece_radius(coordinates[:, :-3]) == pytest.approx(1, rel=1e-3)
    assert piece_radius(coordinates[:, -3:]) == pytest.approx(1, rel=1e-3)


def test_where_diffusion_tells_nothing_space_does():
    cloud = figure()
    constant = replace(cloud, eigenfunctions=np.ones_like(cloud.eigenfunctions))
    found = neighbourhoods(constant)
    assert found.shape == (len(cloud), 3)
    ratio = distances(found, np.arange(50)) / np.maximum(distances(cloud.points, np.arange(50)), 1e-12)
    assert np.ptp(ratio[~np.eye(50, dtype=bool)]) < 1e-3 * ratio.max()


def test_the_radius_of_pieces_is_positive_for_any_cloud():
    """Of four points on a line at 0, 1, 2, 3 the piece is that of the last: distances 0, 1, 2, 3."""
    assert piece_radius(np.zeros((9, 3), dtype=np.float32)) == 1.0
    assert piece_radius(np.outer(np.arange(4), [0, 0.6, 0.8]).astype(np.float32)) == pytest.approx(1.5)
