"""Intrinsic symmetries (Sec. 5.2): a cloud matched to its own mirror image.

The paper matches a cloud to itself; then the identity is the best map of all. Reflecting one copy in a plane
leaves every intrinsic quantity as it is, but turns the identity into a map that would have to turn the body
inside out. What deforms well onto the reflected copy is the left-right symmetry.

On limbs whose front and back are alike, turning the front to the back deforms as well. It leaves every point
in its medial region, so it is the identity as far as medial regions go, and is not wanted.
"""

from dataclasses import replace

import numpy as np

from datasets_gen.records import InputError
from medial.diffusion import Diffusion
from medial.matching.common_units import common_units
from medial.matching.confidence import SAME_PLACE
from medial.matching.config import MatchConfig
from medial.matching.landmarks.medial_paths import MedialPaths, path_distortion
from medial.matching.match import match, match_pair
from medial.matching.nearest import single_blas_thread
from medial.matching.prepared import prepare_pair
from medial.matching.registration.placement import UNMOVED, unmoved_share
from medial.matching.result import Matching
from medial.matching.without_strays import WithoutStrays, of_all_points

REFLECTION = np.array([-1.0, 1.0, 1.0])
"""Factors of the coordinates: the reflection in the plane x = 0."""
KEPT_PATHS = 0.05
"""Mean change of path lengths, in sqrt(area), from which a symmetry is in doubt. Both clouds are one scan, so
nothing but the gaps of the scan makes a difference: right ones were at .02 to .05, head for tail at .1."""


def mirror_image(diffusion: Diffusion) -> Diffusion:
    """The cloud reflected in the plane x = 0; its spectrum stays the same."""
    return replace(
        diffusion,
        points=diffusion.points * REFLECTION,
        normals=diffusion.normals * REFLECTION,
        centers=diffusion.centers * REFLECTION,
    )


def intrinsic_symmetry(
    diffusion: Diffusion, config: MatchConfig | str | None = None, seed: int = 0
) -> Matching:
    """Find the non-trivial symmetry of a cloud.

    Parameters
    ----------
    diffusion
    config, seed
        As for `medial.match`. The selection must be by fit, as it is by default: Eq. 17 alone
        cannot tell a symmetry from the identity. With the departure `mirrored_symmetry` switched off, the
        cloud is matched to itself, as Sec. 5.2 writes, with any settings.

    Returns
    -------
    Matching
        `source_to_target` sends every point to its counterpart on the same cloud; `confidence` is low
        where the other side was not scanned, and everywhere if there is no symmetry but the identity.

    Raises
    ------
    InputError
        If the selection is not by fit.
    """
    part = WithoutStrays.of(diffusion)
    return of_all_points(_symmetry(part.diffusion, config, seed), part, part)


def _symmetry(diffusion: Diffusion, config: MatchConfig | str | None, seed: int) -> Matching:
    """`intrinsic_symmetry` of a cloud without strays."""
    config = MatchConfig.of(config, diffusion.departures)
    if not (config.departures or diffusion.departures).mirrored_symmetry:
        return match(diffusion, diffusion, config, seed)
    if config.selection != "fit":
        raise InputError(
            f"a symmetry needs match setting selection = 'fit', got {config.selection!r}: Eq. 17 cannot tell "
            "it from the identity; to match the cloud to itself, switch the departure mirrored_symmetry off"
        )
    cloud = common_units(diffusion, diffusion)[0]
    paths = MedialPaths.of(cloud)
    with single_blas_thread():
        pair = prepare_pair(diffusion, mirror_image(diffusion), config, seed, paths.outer_half())
        found = match_pair(pair)
    images, samples = found.source_to_target, pair.source.descriptors.samples
    outer = np.flatnonzero(paths.outer_half())
    if unmoved_share(cloud, outer, images[outer]) > UNMOVED:
        return replace(found, confidence=np.zeros(len(cloud)))
    change = path_distortion(paths, paths, samples, images[samples])
    there_and_back = np.linalg.norm(cloud.points[images[images]] - cloud.points, axis=1)
    belief = min(1.0, (KEPT_PATHS / max(change, KEPT_PATHS)) ** 2) / (1 + (there_and_back / SAME_PLACE) ** 4)
    return replace(found, confidence=found.confidence * belief)
