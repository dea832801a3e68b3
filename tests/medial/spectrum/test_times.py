import numpy as np
import pytest

from datasets_gen.records import InputError
from medial.spectrum.times import first_positive_mode, logarithmic_times


def test_times_skip_the_zeros_of_components():
    times = logarithmic_times(np.array([0, 1e-15, 0.5, 2.0, 8.0]), count=5)
    assert times[0] == pytest.approx(4 * np.log(10) / 8)
    assert times[-1] == pytest.approx(4 * np.log(10) / 0.5)
    assert np.allclose(np.diff(np.log(times)), np.log(16) / 4)


def test_several_spectra_share_the_geometric_means_of_their_ends():
    one, other = np.array([0, 1.0, 4.0]), np.array([0, 0, 4.0, 9.0])
    times = logarithmic_times(one, other, count=3)
    assert times[[0, -1]] == pytest.approx(4 * np.log(10) / np.array([6, 2]))
    assert (times == logarithmic_times(other, one, count=3)).all()
    assert len(logarithmic_times(one)) == 25


def test_zero_is_relative_to_the_largest_eigenvalue():
    assert first_positive_mode(np.array([0, 0.9e-8, 1.1e-8, 1.0])) == 2
    assert first_positive_mode(1e6 * np.array([0, 0.9e-8, 1.1e-8, 1.0])) == 2


@pytest.mark.parametrize("call", [first_positive_mode, logarithmic_times])
def test_no_positive_eigenvalue(call):
    with pytest.raises(InputError, match="no positive eigenvalue among 3 modes"):
        call(np.zeros(3))
