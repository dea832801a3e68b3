"""Points spread evenly over the sphere."""

import numpy as np

from datasets_gen.points.fibonacci import fibonacci_sphere


def test_even_directions_are_unit_and_balanced():
    directions = fibonacci_sphere(200)
    assert np.allclose(np.linalg.norm(directions, axis=1), 1)
    assert np.abs(directions.mean(axis=0)).max() < 0.01
