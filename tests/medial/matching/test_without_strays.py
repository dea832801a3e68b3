"""Diffusions with stray points are matched as if there were none."""

import numpy as np
import pytest

from datasets_gen.records import InputError
from medial import Diffusion, intrinsic_symmetry, match
from medial.matching.match import extrapolate
from medial.matching.without_strays import WithoutStrays
from tests.little_matching import CHEAP
from tests.medial import clouds


@pytest.fixture(scope="module")
def pair():
    points, normals = clouds.body(300)
    strewn = np.concatenate([points, [[1e5, 0, 0], [0, 2e5, 0]]]), np.concatenate([normals, np.eye(3)[:2]])
    return Diffusion.from_points(points, normals, modes=20), Diffusion.from_points(*strewn, modes=20)


def test_nothing_changes_without_strays(pair):
    assert WithoutStrays.of(pair[0]).diffusion is pair[0]
    part = WithoutStrays.of(pair[1])
    assert np.array_equal(part.kept, np.arange(300))
    assert np.array_equal(part.diffusion.eigenfunctions, pair[0].eigenfunctions)
    assert (part.nearest[300:] < 300).all()


def test_maps_and_symmetries_are_those_of_the_other_points(pair):
    clean, strewn = pair
    for plain, found in (
        (match(clean, clean, CHEAP), match(strewn, strewn, CHEAP)),
        (intrinsic_symmetry(clean, CHEAP), intrinsic_symmetry(strewn, CHEAP)),
    ):
        assert np.array_equal(found.source_to_target[:300], plain.source_to_target)
        assert np.array_equal(found.confidence[:300], plain.confidence)
        assert (found.confidence[300:] == 0).all()
        assert (found.source_to_target < 300).all()


def test_a_stray_landmark_is_refused(pair):
    with pytest.raises(InputError, match="a landmark is a stray point"):
        extrapolate(pair[0], pair[1], np.array([[0, 300]]))
