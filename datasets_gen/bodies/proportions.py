"""Mirror images and proportions of bodies: every part, bone and detail follows the region that it lies in."""

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from datasets_gen.bodies.body_plan import BodyPlan, Skin
from datasets_gen.bodies.implicit_surface import Body, Part, unit
from datasets_gen.bodies.skeleton import Skeleton, other_side

Array = NDArray[np.float64]

FLIP = np.array([-1.0, 1.0, 1.0])


def mirrored(part: Part) -> Part:
    """The part across x = 0, with the bones of the other side."""
    axes = part.axes * FLIP
    axes[0] *= -1  # keeps the frame right-handed
    return replace(
        part,
        bones=tuple(other_side(name) for name in part.bones),
        start=part.start * FLIP,
        axes=axes,
        profile=part.profile * np.array([1, 1, 1, -1, 1]),
    )


def both_sides(left: Iterable[Part]) -> tuple[Part, ...]:
    """Parts of the left side and their mirror images."""
    parts = tuple(left)
    return parts + tuple(mirrored(part) for part in parts)


@dataclass(frozen=True)
class Region:
    """A piece of a body that is scaled as one.

    Attributes
    ----------
    parent : str or None
        Region that carries it.
    anchor : (3,)
        Point at which it joins its parent.
    axis : (3,)
        Direction of its length.
    bones : tuple of str
    """

    parent: str | None
    anchor: Array
    axis: Array
    bones: tuple[str, ...]


def side_regions(left: dict[str, Region]) -> dict[str, Region]:
    """Regions of the left side and their mirror images."""
    right = {
        other_side(name): Region(
            other_side(region.parent) if region.parent else None,
            region.anchor * FLIP,
            region.axis * FLIP,
            tuple(other_side(bone) for bone in region.bones),
        )
        for name, region in left.items()
    }
    return left | right


@dataclass(frozen=True)
class Affine:
    """x -> matrix x + shift."""

    matrix: Array
    shift: Array

    def __call__(self, point: Array) -> Array:
        """Image of a point (3,)."""
        return self.matrix @ point + self.shift


def region_maps(
    regions: Mapping[str, Region], scales: Mapping[str, tuple[float, float]]
) -> dict[str, Affine]:
    """Map of each region, which stretches it about its anchor and follows its parent.

    Parameters
    ----------
    regions
        Parents before children.
    scales
        (length, girth) factors of regions; 1 where absent.
    """
    maps: dict[str, Affine] = {}
    for name, region in regions.items():
        length, girth = scales.get(name, (1.0, 1.0))
        along = np.outer(unit(region.axis), unit(region.axis))
        matrix = length * along + girth * (np.eye(3) - along)
        anchor = maps[region.parent](region.anchor) if region.parent else region.anchor
        maps[name] = Affine(matrix, anchor - matrix @ region.anchor)
    return maps


def bone_maps(regions: Mapping[str, Region], scales: Mapping[str, tuple[float, float]]) -> dict[str, Affine]:
    """Map of each bone: that of its region (`region_maps`)."""
    maps = region_maps(regions, scales)
    return {name: maps[region] for region, value in regions.items() for name in value.bones}


def scaled_skeleton(skeleton: Skeleton, of_bone: Mapping[str, Affine]) -> Skeleton:
    """A skeleton whose joints follow the maps of their bones; axes stay."""
    bones = [replace(b, head=of_bone[b.name](b.head), tail=of_bone[b.name](b.tail)) for b in skeleton.bones]
    return replace(skeleton, bones=tuple(bones))


def varied_skin(skin: Skin, regions: Mapping[str, Region], scales: Mapping[str, tuple[float, float]]) -> Skin:
    """The skin of a subject of other proportions with the same vertices and faces: truth across subjects.

    A vertex follows the maps of its bones, weighted as its bones move it, so that regions pass into each
    other smoothly. The map is not isometric.

    Parameters
    ----------
    skin
    regions
        Parents before children; every bone belongs to one.
    scales
        (length, girth) factors of regions; 1 where absent.
    """
    of_bone = bone_maps(regions, scales)
    maps = [of_bone[bone.name] for bone in skin.skeleton.bones]
    matrices, shifts = np.stack([each.matrix for each in maps]), np.stack([each.shift for each in maps])
    blended = np.einsum("vb,bij->vij", skin.weights, matrices)
    moved = np.einsum("vij,vj->vi", blended, skin.vertices) + skin.weights @ shifts
    return replace(skin, vertices=moved, skeleton=scaled_skeleton(skin.skeleton, of_bone))


def scaled_part(part: Part, by: Affine) -> Part:
    """A part whose position and sizes follow a map; its cross-sections stay super-ellipses."""
    side, along, front = (float(np.linalg.norm(by.matrix @ axis)) for axis in part.axes)
    axis = unit(by.matrix @ part.axes[1])
    forward = part.axes[2] - (part.axes[2] @ axis) * axis
    return replace(
        part,
        start=by(part.start),
        axes=np.stack([np.cross(axis, unit(forward)), axis, unit(forward)]),
        length=part.length * along,
        profile=part.profile * np.array([1, side, front, side, front]),
        caps=(part.caps[0] * along, part.caps[1] * along),
        blend=part.blend * float(np.cbrt(side * along * front)),
    )


def proportioned(
    plan: BodyPlan, regions: Mapping[str, Region], scales: Mapping[str, tuple[float, float]]
) -> BodyPlan:
    """A plan whose regions are scaled; parts, bones and details go with the region of their (first) bone.

    Parameters
    ----------
    plan
    regions
        Parents before children; every bone belongs to one.
    scales
        (length, girth) factors of regions; 1 where absent.
    """
    of_bone = bone_maps(regions, scales)
    skeleton = scaled_skeleton(plan.skeleton, of_bone)
    parts = [scaled_part(part, of_bone[part.bones[0]]) for part in plan.surface.parts]
    details = [replace(d, center=of_bone[d.bone](d.center)) for d in plan.details]
    return replace(plan, skeleton=skeleton, surface=Body(tuple(parts)), details=tuple(details))


def random_scales(
    regions: Mapping[str, Region],
    seed: int,
    *,
    lengths: tuple[float, float] = (0.93, 1.07),
    girths: tuple[float, float] = (0.9, 1.1),
    same_length: Mapping[str, str] | None = None,
) -> dict[str, tuple[float, float]]:
    """Random proportions, equal on both sides.

    Parameters
    ----------
    regions
    seed
        0 is the default body.
    lengths, girths
        Ranges of the factors.
    same_length
        Regions of the left side that take the length of another, so that all feet stay level.

    Returns
    -------
    dict
        (length, girth) factors by region; empty for the default body.
    """
    if seed == 0:
        return {}
    rng = np.random.default_rng(seed)
    scales: dict[str, tuple[float, float]] = {}
    for name in regions:
        if not name.endswith(".R"):
            scales[name] = (float(rng.uniform(*lengths)), float(rng.uniform(*girths)))
    for name, like in (same_length or {}).items():
        scales[name] = (scales[like][0], scales[name][1])
    return scales | {other_side(name): value for name, value in scales.items()}
