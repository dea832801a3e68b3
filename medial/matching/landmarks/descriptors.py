"""What points are compared by: the heat kernel m_t from landmarks and the signature m_t(x, x) (Eqs. 16-17).

Both are divided by the heat trace at each time, so that no time outweighs the others, and multiplied by the
cloud's own area, so that clouds of which different parts are missing compare.
"""

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from medial.diffusion import Diffusion, decay
from medial.matching.nearest import single_blas_thread


@dataclass(frozen=True)
class DiffusionDescriptors:
    """m_t of a cloud over the heat trace, as Eqs. 16 and 17 compare it.

    Attributes
    ----------
    diffusion : Diffusion
    samples : (s,) int64
        Point ids of S_P or S_Q.
    decay : (k, T) float32
        exp(-lambda_i t) over the heat trace at t (`medial.diffusion.decay`).
    psi : (n, k) float32
        Eigenfunctions; in units in which the cloud's total area is 1 unless kernels are taken as written.
    signature : (s, T) float32
        m_t(x, x) of the samples, divided by the heat trace.
    """

    diffusion: Diffusion
    samples: NDArray[np.int64]
    decay: NDArray[np.float32]
    psi: NDArray[np.float32]
    signature: NDArray[np.float32]
    _kept: dict[int, NDArray[np.float32]] = field(default_factory=dict, repr=False, compare=False)

    def heat(self, landmark: int, rows: NDArray[np.integer] | slice) -> NDArray[np.float32]:
        """m_o(landmark, x) for some points x: one column per time, (rows, T)."""
        return self.psi[rows] @ (self.psi[landmark][:, None] * self.decay)

    def among_samples(self, sample: int) -> NDArray[np.float32]:
        """m_o between a sample, given by its position, and all samples, (s, T).

        Kept, as searches from different starts ask for the same samples. Each is computed by itself: its
        last digits do not depend on which others are.
        """
        found = self._kept.get(sample)
        if found is None:
            found = self._kept[sample] = self.heat(int(self.samples[sample]), self.samples)
        return found

    def signatures(self, rows: NDArray[np.integer] | slice) -> NDArray[np.float32]:
        """m_o(x, x) for some points x, (rows, T)."""
        return self.psi[rows] ** 2 @ self.decay


def middle_time(times: NDArray[np.float64]) -> float:
    """The middle of logarithmic times."""
    return float(np.sqrt(times[0] * times[-1]))


def describe(
    diffusion: Diffusion,
    times: NDArray[np.float64],
    samples: NDArray[np.int64],
    area_normalised: bool = True,
) -> DiffusionDescriptors:
    """Tabulate the heat traces of a cloud and the signatures of its samples.

    Parameters
    ----------
    diffusion
    times : (T,) float64
        Shared with the cloud it is compared to.
    samples : (s,) int64
        Point ids of S_P or S_Q.
    area_normalised
        Multiply m_t by the cloud's area (`medial.departures.Departures.area_normalised_kernels`).
    """
    unit = np.sqrt(diffusion.areas.sum()) if area_normalised else 1.0
    psi = (diffusion.eigenfunctions * unit).astype(np.float32)
    left = (decay(diffusion.eigenvalues, times) / diffusion.heat_trace(times)).astype(np.float32)
    with single_blas_thread():
        return DiffusionDescriptors(diffusion, samples, left, psi, psi[samples] ** 2 @ left)
