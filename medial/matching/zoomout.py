"""Spectral refinement (ZoomOut): a map improved in more and more modes of the operator."""

import numpy as np
from numpy.typing import NDArray

from medial.diffusion import Diffusion
from medial.matching.nearest import nearest

Int = NDArray[np.int64]

SPECTRAL_MODES = (20, 30, 40, 55, 70, 90, 115, 150)
"""Numbers of modes of the successive functional maps."""


def spectral_refinement(
    source: Diffusion, target: Diffusion, source_to_target: Int, sizes: tuple[int, ...] = SPECTRAL_MODES
) -> Int:
    """Alternate functional maps and nearest neighbours, with more and more modes.

    The functional map takes functions on the target to the source by area-weighted projection.

    Parameters
    ----------
    source, target
    source_to_target : (n_source,) int64
    sizes
        Numbers of modes, ascending; those larger than what both clouds have are left out.

    Returns
    -------
    (n_source,) int64

    References
    ----------
    Melzi, Ren, Rodolà, Sharma, Wonka, Ovsjanikov: ZoomOut: spectral upsampling for efficient shape
    correspondence. SIGGRAPH Asia 2019.
    """
    modes = min(source.eigenfunctions.shape[1], target.eigenfunctions.shape[1])
    for k in (size for size in sizes if size <= modes):
        here, there = source.eigenfunctions[:, :k], target.eigenfunctions[:, :k]
        functional = (here * source.areas[:, None]).T @ there[source_to_target]  # (k, k): target to source
        source_to_target, _ = nearest(here, there @ functional.T)
    return source_to_target
