"""Spectral refinement."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from medial.matching.zoomout import spectral_refinement
from tests.medial.posed import bent, figure


@pytest.fixture(scope="module")
def spectrum():
    return figure(modes=100)


def test_spectral_refinement_keeps_the_identity(spectrum):
    found = spectral_refinement(spectrum, spectrum, np.arange(len(spectrum)))
    moved = np.flatnonzero(found != np.arange(len(spectrum)))
    assert len(moved) <= len(spectrum) / 100  # in 20 modes, in single precision, two points may be one
    first = spectrum.eigenfunctions[:, :20] / np.linalg.norm(spectrum.eigenfunctions[:, :20], axis=1).max()
    assert np.allclose(first[moved], first[found[moved]], atol=1e-3)


def noisy(points, size):
    """The identity with an error."""
    return cKDTree(points).query(points + np.random.default_rng(0).normal(0, size, points.shape))[1]


def test_spectral_refinement_repairs_a_noisy_identity(spectrum):
    start = noisy(spectrum.points, 0.1)
    end = spectral_refinement(spectrum, spectrum, start)
    before, after = (
        np.linalg.norm(spectrum.points[m] - spectrum.points, axis=1).mean() for m in (start, end)
    )
    assert before > 0.1
    assert after < before / 4


def test_more_modes_than_there_are_end_the_refinement(spectrum):
    start = noisy(spectrum.points, 0.1)
    assert np.array_equal(spectral_refinement(spectrum, spectrum, start, (101, 150)), start)
    few = spectral_refinement(spectrum, spectrum, start, (20, 40))
    assert np.array_equal(spectral_refinement(spectrum, spectrum, start, (20, 40, 101)), few)
    assert not np.array_equal(few, start)


def test_spectral_refinement_of_two_poses():
    """A pose changes the spectrum a little; the map from one basis to the other is found along the way."""
    points, normals = bent(figure().points, figure().normals, 0.6)
    posed = type(figure()).from_points(points, normals, modes=60)
    start = noisy(figure().points, 0.08)
    end = spectral_refinement(figure(), posed, start, (20, 30, 40, 55))
    before, after = (np.linalg.norm(points[m] - points, axis=1).mean() for m in (start, end))
    assert after < 0.7 * before
