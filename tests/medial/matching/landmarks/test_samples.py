import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from datasets_gen.records import InputError
from medial.matching.landmarks.samples import (
    diffusion_map,
    farthest_points,
    first_positive_mode,
    smallest_time,
    spectral_samples,
)
from tests.medial.matching_shapes import unequal_arms


@pytest.fixture(scope="module")
def shape():
    return unequal_arms()


def test_diffusion_map_distances_are_those_of_the_kernel(shape):
    time = 3 * smallest_time(shape)
    x = diffusion_map(shape, time)
    ids = np.array([3, 50, 400])
    kernel = shape.kernel(2 * time, ids, ids)
    expected = np.diag(kernel)[:, None] + np.diag(kernel) - 2 * kernel
    found = ((x[ids][:, None] - x[ids]) ** 2).sum(axis=2)
    np.testing.assert_allclose(found, expected, atol=1e-9)


def slow_farthest_points(x, count, start, chosen):
    """Squared gaps to all points picked before; of equal ones the first, and none twice."""
    order = [start]
    while len(order) < min(count, len(x)):
        gap = ((x[:, None] - x[[*chosen, *order]]) ** 2).sum(axis=2).min(axis=1)
        gap[order] = -np.inf
        order.append(int(gap.argmax()))
    return order


@settings(max_examples=60, deadline=None, derandomize=True, database=None)
@given(st.data())
def test_farthest_points_matches_a_slow_one(data):
    """On a small grid, so that points coincide and gaps are equal."""
    n, d = data.draw(st.integers(1, 60)), data.draw(st.sampled_from([1, 2, 3, 9]))
    x = np.random.default_rng(data.draw(st.integers(0, 99))).integers(0, 6, (n, d)).astype(float)
    chosen = data.draw(st.lists(st.integers(0, n - 1), max_size=4))
    start, count = data.draw(st.integers(0, n - 1)), data.draw(st.integers(1, n + 3))
    found = farthest_points(x, count, start, chosen=np.array(chosen, dtype=np.int64))
    assert found.tolist() == slow_farthest_points(x, count, start, chosen)


def test_farthest_points_of_many_dimensions_matches_a_slow_one():
    x = np.random.default_rng(0).normal(size=(300, 40))
    assert farthest_points(x, 90, 7).tolist() == slow_farthest_points(x, 90, 7, [])


def test_farthest_points_of_identical_points_are_distinct():
    assert sorted(farthest_points(np.zeros((9, 3)), 20, 4)) == list(range(9))


def test_samples_are_distinct_and_cover(shape):
    samples = spectral_samples(shape, 120, np.random.default_rng(0))
    assert len(np.unique(samples)) == 120
    x = diffusion_map(shape, smallest_time(shape))
    rng = np.random.default_rng(0)

    def spread(ids):
        return (np.linalg.norm(x[:, None] - x[ids], axis=2).min(axis=1) ** 2).mean()

    random = np.mean([spread(rng.choice(len(shape), 120, replace=False)) for _ in range(5)])
    assert spread(samples) < 0.7 * random  # the best possible in a plane is 0.5


def test_clouds_smaller_than_the_sample_are_used_whole(shape):
    assert spectral_samples(shape, 10**6, np.random.default_rng(0)).tolist() == list(range(len(shape)))


def test_first_positive_mode_skips_components():
    assert first_positive_mode(np.array([0, 1e-17, 0.2, 1.0])) == 2
    with pytest.raises(InputError, match="no positive eigenvalue"):
        first_positive_mode(np.zeros(4))
