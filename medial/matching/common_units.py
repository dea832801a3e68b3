"""Two clouds in common units."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError
from medial.diffusion import Diffusion

Float = NDArray[np.float64]
Int = NDArray[np.int64]

MOST_POINTS = 8000
"""Points of a cloud that the search sees; what it finds is carried over to all points in the end."""
GROSS = 1.4
"""Ratio of sizes up to which two clouds may be scans of one subject in the same units."""
SLIGHT = 1.2
"""Ratio of sizes from which they differ if all estimates agree about the ratio."""
AGREE = 1.15
"""Ratio of the largest to the smallest estimate up to which they agree."""
SETTINGS = ("eta", "sigma_e", "sigma_t", "cutoff", "reference_points")
"""Of the medial operator: what its heat kernel depends on, beside the departures."""
ESTIMATES = 3
"""Of the ratio of sizes; surface operators know no radii, and two estimates may agree by chance."""
UNKNOWN = "unknown"
"""A setting that a diffusion does not tell."""


@dataclass(frozen=True)
class CloudInUnits:
    """A cloud in the units of its pair: lengths are in square roots of the surface area.

    Attributes
    ----------
    points, normals, centers : (n, 3) float64
        Medial centres are the points themselves for surface operators.
    radii : (n,) float64
        Medial radii; 0 for surface operators.
    """

    points: Float
    normals: Float
    centers: Float
    radii: Float

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.points)

    @property
    def features(self) -> Float:
        """Positions and medial centres, (n, 6): near in both means near along the body."""
        return np.hstack([self.points, self.centers])


def check_comparable(source: Diffusion, target: Diffusion, purpose: str = "match") -> None:
    """Check that two diffusions come from one operator with one choice of settings.

    Raises
    ------
    InputError
        If they do not: their heat kernels differ even where the clouds do not.
    """
    if source.operator != target.operator:
        raise InputError(
            f"cannot {purpose} a {source.operator!r} diffusion to a {target.operator!r} one; use one operator"
        )
    if source.departures != target.departures:
        raise InputError(
            f"cannot {purpose} diffusions with different departures from the paper; "
            "build both with one departures="
        )
    for name in SETTINGS if source.operator == "medial" else ():
        here, there = (each.parameters.get(name, UNKNOWN) for each in (source, target))
        if UNKNOWN not in (here, there) and here != there:
            raise InputError(
                f"cannot {purpose} diffusions built with {name}={here!r} and {name}={there!r}; use one {name}"
            )


def in_source_units(source: Diffusion, target: Diffusion) -> tuple[Diffusion, Diffusion]:
    """The source as it is, and the target in the source's units; unchanged if both have the same."""
    scale = relative_scale(source, target)
    return source, target if scale == 1 else rescaled(target, scale)


def rescaled(diffusion: Diffusion, factor: float) -> Diffusion:
    """The diffusion of the same cloud in other units.

    Parameters
    ----------
    diffusion
    factor
        New lengths over old lengths.

    Returns
    -------
    Diffusion
        What the operator gives for ``factor * points``, up to rounding.
    """
    return replace(
        diffusion,
        points=diffusion.points * factor,
        areas=diffusion.areas * factor**2,
        eigenvalues=diffusion.eigenvalues * factor ** eigenvalue_dimension(diffusion),
        eigenfunctions=diffusion.eigenfunctions / factor,
        centers=diffusion.centers * factor,
        radii=diffusion.radii * factor,
    )


def eigenvalue_dimension(diffusion: Diffusion) -> int:
    """Power of the unit of length in the eigenvalues of an operator.

    Surface Laplacians have one over squared lengths. In Eq. 8 similarities without unit are summed over
    areas; the weights of Eq. 15 are divided by such sums.
    """
    if diffusion.operator != "medial":
        return -2
    return 2 if diffusion.parameters.get("eta", 0.5) is None else 0


def common_units(source: Diffusion, target: Diffusion) -> tuple[CloudInUnits, CloudInUnits]:
    """Both clouds in square roots of the larger one's area."""
    source, target = in_source_units(source, target)
    unit = 1 / float(np.sqrt(max(source.areas.sum(), target.areas.sum())))
    first, second = (
        CloudInUnits(d.points * unit, d.normals, d.centers * unit, d.radii * unit) for d in (source, target)
    )
    return first, second


def relative_scale(source: Diffusion, target: Diffusion) -> float:
    """Factor that brings the target to the source's units; 1 unless the clouds' sizes differ grossly.

    Scans of one subject share their units. Each estimate of a ratio of sizes has its weakness, so the sizes
    differ only if all of them say so: each by more than `GROSS`, or by more than `SLIGHT` and all by the
    same. Then their median tells by how much.
    """
    found = zip(sizes(source), sizes(target), strict=True)
    ratios = np.array([here / there for here, there in found if here > 0 and there > 0])
    if not len(ratios) or ratios.min() < 1 < ratios.max():
        return 1.0
    logs = np.log(ratios)
    least, spread = np.exp(np.abs(logs).min()), np.exp(np.ptp(logs))
    differ = least > GROSS or (len(ratios) == ESTIMATES and least > SLIGHT and spread < AGREE)
    return float(np.exp(np.median(logs))) if differ else 1.0


def sizes(diffusion: Diffusion) -> tuple[float, float, float]:
    """Lengths that tell how large a body is, each with its own weakness; 0 where unknown.

    Returns
    -------
    radius
        Median medial radius; too large where empty balls span limbs whose surfaces are missing.
    side
        Square root of the area; too small where much is missing.
    extent
        Root mean square distance from the centre of mass; depends on the pose, and on which part is missing.
    """
    areas = diffusion.areas
    centred = diffusion.points - np.average(diffusion.points, axis=0, weights=areas)
    extent = np.sqrt(np.average((centred**2).sum(axis=1), weights=areas))
    return float(np.median(diffusion.radii)), float(np.sqrt(areas.sum())), float(extent)
