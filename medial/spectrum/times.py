"""Logarithmic diffusion times of one spectrum or of several that are compared (Sec. 4, Eq. 18)."""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError

DECADES = 4 * np.log(10)
"""4 ln 10 of [SOG09]: a mode has decayed by four decades at this over its eigenvalue."""
ZERO = 1e-8
"""Eigenvalues up to this share of the largest are the zeros of connected components."""
TIMES = 25
"""|T|: number of times in the paper."""


def first_positive_mode(eigenvalues: NDArray[np.float64]) -> int:
    """Index of the first eigenvalue that is not zero (one zero per connected component).

    Parameters
    ----------
    eigenvalues : (k,)
        Ascending.

    Raises
    ------
    InputError
        If all eigenvalues are zero.
    """
    positive = np.flatnonzero(eigenvalues > ZERO * eigenvalues[-1])
    if eigenvalues[-1] <= 0 or len(positive) == 0:
        raise InputError(
            f"no positive eigenvalue among {len(eigenvalues)} modes; use a larger cloud or more modes"
        )
    return int(positive[0])


def shortest_time(eigenvalues: NDArray[np.float64]) -> float:
    """Time at which the highest mode has decayed by four decades: 4 ln 10 / lambda_max [SOG09]."""
    return float(DECADES / eigenvalues[-1])


def longest_time(eigenvalues: NDArray[np.float64]) -> float:
    """Time at which the first positive mode has decayed by four decades: 4 ln 10 / lambda_2 [SOG09]."""
    return float(DECADES / eigenvalues[first_positive_mode(eigenvalues)])


def logarithmic_times(*spectra: NDArray[np.float64], count: int = TIMES) -> NDArray[np.float64]:
    """Times evenly spaced in their logarithm, from 4 ln 10 / lambda_max to 4 ln 10 / lambda_2 [SOG09].

    Parameters
    ----------
    *spectra : (k,) each
        Ascending eigenvalues of one or more operators, in the same units. Several share one set of times:
        each end is the geometric mean of theirs.
    count
        Number of times.

    Returns
    -------
    (count,) float64
        Ascending, in the reciprocal unit of the eigenvalues.

    Raises
    ------
    InputError
        If a spectrum has no positive eigenvalue.
    """
    ends = []
    for each in spectra:
        longest = longest_time(each)
        ends.append((shortest_time(each), longest))
    if len(ends) > 1:  # one spectrum's own ends would lose their last digit on the way through the logarithm
        ends = [tuple(np.exp(np.log(ends).mean(axis=0)).tolist())]
    return np.geomspace(*ends[0], count)
