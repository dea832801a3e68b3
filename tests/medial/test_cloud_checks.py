"""Clouds that no operator can be built on."""

import numpy as np
import pytest

from datasets_gen import InputError
from medial import Diffusion
from medial.validation import LARGEST_EXTENT
from tests.medial.clouds import sphere


@pytest.mark.parametrize("factor", [1e-200, 1e-30, 1e30, 1e200])
def test_sizes_beyond_single_precision_are_refused(factor):
    """Their squares are 0 or infinite there, which ends in any error, or in the end of the process."""
    points, normals = sphere(50)
    with pytest.raises(InputError, match=r"the points are .* across; choose units in which it is between"):
        Diffusion.from_points(points * factor, normals)


@pytest.mark.parametrize("size", [1.01 / LARGEST_EXTENT, 0.99 * LARGEST_EXTENT])
def test_sizes_up_to_there_make_no_difference(size):
    points, normals = sphere(400)
    plain = Diffusion.from_points(points, normals, modes=12)
    found = Diffusion.from_points(points * (size / np.ptp(points, axis=0).max()), normals, modes=12)
    assert found.eigenvalues == pytest.approx(plain.eigenvalues, rel=1e-3, abs=1e-6)


def test_points_at_one_place_are_said_to_be():
    with pytest.raises(InputError, match="all 20 points lie at one place"):
        Diffusion.from_points(np.ones((20, 3)), np.eye(3)[np.zeros(20, int)])
