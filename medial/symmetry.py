"""Intrinsic symmetries (Sec. 5.2): a cloud matched to its own mirror image.

The paper matches a cloud to itself; then the identity is the best map of all. Reflecting one copy in a plane
leaves every intrinsic quantity as it is, but turns the identity into a map that would have to turn the body
inside out. What deforms well onto the reflected copy is the left-right symmetry.
"""

from dataclasses import replace

import numpy as np

from medial.diffusion import Diffusion
from medial.matching import match
from medial.matching_types import MatchConfig, Matching

REFLECTION = np.array([-1.0, 1.0, 1.0])


def mirror_image(diffusion: Diffusion) -> Diffusion:
    """The cloud reflected in the plane x = 0; its spectrum stays the same."""
    return replace(
        diffusion,
        points=diffusion.points * REFLECTION,
        normals=diffusion.normals * REFLECTION,
        centers=diffusion.centers * REFLECTION,
        surface=None if diffusion.surface is None else mirror_image(diffusion.surface),
    )


def intrinsic_symmetry(diffusion: Diffusion, config: MatchConfig | None = None, seed: int = 0) -> Matching:
    """Find the non-trivial symmetry of a cloud.

    Parameters
    ----------
    diffusion
    config, seed
        As for `medial.match`. The selection must be by fit, as it is by default: Eq. 17 alone
        cannot tell a symmetry from the identity.

    Returns
    -------
    Matching
        `source_to_target` sends every point to its counterpart on the same cloud; `confidence` is low
        where the other side was not scanned, and everywhere if there is no symmetry.
    """
    return match(diffusion, mirror_image(diffusion), config, seed)
