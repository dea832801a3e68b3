"""Intrinsic symmetries (Sec. 5.2): a cloud matched to its own mirror image.

The paper matches a cloud to itself; then the identity is the best map of all. Reflecting one copy in a plane
leaves every intrinsic quantity as it is, but turns the identity into a map that would have to turn the body
inside out. What deforms well onto the reflected copy is the left-right symmetry. On limbs that have little to
tell front from back a turn of the front to the back does as well, which leaves the medial structure where it
is; that one is not wanted.
"""

from dataclasses import replace

import numpy as np

from medial.diffusion import Diffusion
from medial.matching.common_units import common_units
from medial.matching.confidence import SAME_PLACE
from medial.matching.config import MatchConfig, Matching
from medial.matching.landmarks.medial_paths import MedialPaths, path_distortion
from medial.matching.match import Pair
from medial.matching.nearest import single_blas_thread
from medial.matching.registration.direction import STAYING, staying

REFLECTION = np.array([-1.0, 1.0, 1.0])
KEPT_PATHS = 0.05
"""Mean change of path lengths, in sqrt(area), from which a symmetry is in doubt. Both ends are one scan, so
nothing but the gaps of the scan makes a difference: right ones were at .02 to .05, head for tail at .1."""


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
        where the other side was not scanned, and everywhere if there is no symmetry but the identity.
    """
    cloud = common_units(diffusion, diffusion)[0]
    paths = MedialPaths.of(cloud)
    with single_blas_thread():
        image = mirror_image(diffusion)
        pair = Pair(diffusion, image, config or MatchConfig(), seed, paths.outer_half())
        found = pair.match()
    images, samples = found.source_to_target, pair.ends[0].side.samples
    outer = np.flatnonzero(paths.outer_half())
    if staying(cloud, outer, images[outer]) > STAYING:
        return replace(found, confidence=np.zeros(len(cloud)))
    change = path_distortion(paths, paths, samples, images[samples])
    there_and_back = np.linalg.norm(cloud.points[images[images]] - cloud.points, axis=1)
    belief = min(1.0, (KEPT_PATHS / max(change, KEPT_PATHS)) ** 2) / (1 + (there_and_back / SAME_PLACE) ** 4)
    return replace(found, confidence=found.confidence * belief)
