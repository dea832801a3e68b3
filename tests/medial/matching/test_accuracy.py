"""Cut-off, single precision and 300 modes change Eq. 18 by less than 1 %."""

import numpy as np
import pytest

from medial import Diffusion
from tests.medial import clouds
from tests.medial.exact_operator import exact, stability_error, times_of, truncated


@pytest.mark.parametrize("points", [700, pytest.param(2000, marks=pytest.mark.slow)])
def test_default_settings_keep_the_value_of_equation_18(points):
    shapes = clouds.body(points), clouds.body(int(0.8 * points), holes=8)
    truth = [exact(*shape) for shape in shapes]
    fast = [Diffusion.from_points(*shape, modes=300) for shape in shapes]
    times = times_of(truncated(truth[0], 300))
    assert stability_error(*fast, times) == pytest.approx(stability_error(*truth, times), rel=0.01)
    assert fast[0].eigenvalues[1:] == pytest.approx(truth[0].eigenvalues[1:300], rel=1e-4)


def test_error_of_equation_18_is_zero_for_the_same_cloud():
    diffusion = Diffusion.from_points(*clouds.body(500), modes=50)
    assert stability_error(diffusion, diffusion, np.array([1.0, 10.0])) == 0
