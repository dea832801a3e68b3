import numpy as np
import pytest

from medial.matching.landmarks.samples import diffusion_map, spectral_samples
from medial.spectrum.times import shortest_time
from tests.medial.matching_shapes import unequal_arms


@pytest.fixture(scope="module")
def shape():
    return unequal_arms()


def test_diffusion_map_distances_are_those_of_the_kernel(shape):
    time = 3 * shortest_time(shape.eigenvalues)
    x = diffusion_map(shape, time)
    ids = np.array([3, 50, 400])
    kernel = shape.kernel(2 * time, ids, ids)
    expected = np.diag(kernel)[:, None] + np.diag(kernel) - 2 * kernel
    found = ((x[ids][:, None] - x[ids]) ** 2).sum(axis=2)
    np.testing.assert_allclose(found, expected, atol=1e-9)


def test_samples_are_distinct_and_cover(shape):
    samples = spectral_samples(shape, 120, np.random.default_rng(0))
    assert len(np.unique(samples)) == 120
    x = diffusion_map(shape, shortest_time(shape.eigenvalues))
    rng = np.random.default_rng(0)

    def uncovered(ids):
        return (np.linalg.norm(x[:, None] - x[ids], axis=2).min(axis=1) ** 2).mean()

    random = np.mean([uncovered(rng.choice(len(shape), 120, replace=False)) for _ in range(5)])
    assert uncovered(samples) < 0.7 * random  # the best possible in a plane is 0.5


def test_clouds_smaller_than_the_sample_are_used_whole(shape):
    assert spectral_samples(shape, 10**6, np.random.default_rng(0)).tolist() == list(range(len(shape)))
