"""Diffusions without their stray points, and the maps found on them as maps of all points."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from datasets_gen.points.strays import nearest_kept, stray_points
from medial.diffusion import Diffusion
from medial.matching.result import Matching

PER_POINT = ("points", "normals", "areas", "eigenfunctions", "centers", "radii")


@dataclass(frozen=True)
class WithoutStrays:
    """The part of a diffusion that is matched.

    Attributes
    ----------
    diffusion : Diffusion
        Of the m points that are not stray; the given object if none is.
    kept : (m,) int64
        Their ids.
    nearest : (n,) int64
        For every point, which of `kept` is nearest.
    stray : (n,) bool
    """

    diffusion: Diffusion
    kept: NDArray[np.int64]
    nearest: NDArray[np.int64]
    stray: NDArray[np.bool_]

    @classmethod
    def of(cls, diffusion: Diffusion) -> "WithoutStrays":
        """Leave the stray points out (`datasets_gen.points.strays`); they have no area anyway."""
        stray = stray_points(diffusion.points)
        kept = np.flatnonzero(~stray)
        if not stray.any():
            return cls(diffusion, kept, kept, stray)
        part = replace(diffusion, **{name: getattr(diffusion, name)[kept] for name in PER_POINT})
        return cls(part, kept, nearest_kept(diffusion.points, stray), stray)


def of_all_points(found: Matching, source: WithoutStrays, target: WithoutStrays) -> Matching:
    """The map with strays: each goes where the nearest other point goes, with confidence 0; none is hit."""
    if not (source.stray.any() or target.stray.any()):
        return found
    return found.extended(source.nearest, source.kept, target.kept, source.stray)
