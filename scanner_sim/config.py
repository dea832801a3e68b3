"""Parameters of the scanner, in millimetres for an object whose largest side is `object_size`."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, fields
from typing import Any, Literal

from datasets_gen.records import InputError
from scanner_sim.viewpoints import check_views

Views = int | str | tuple[tuple[float, float, float], ...]


@dataclass(frozen=True, kw_only=True)
class ScannerConfig:
    """Everything that decides a scan but the shape and the seed.

    The rig is built for an object whose largest bounding-box side measures `object_size` millimetres and
    is scaled to the mesh, so results do not depend on the mesh's units.

    Raises
    ------
    InputError
        If a value is impossible; the message names the field, the value and the remedy.
    """

    views: Views = 10
    """Viewpoints: a count (near-uniform on the sphere), ``"sphere:N"``, ``"ring:N"`` (about `up`),
    ``"opposed"`` (front and back), or directions ``((x, y, z), ...)`` from the object's centre."""

    up: Literal["x", "y", "z"] = "y"
    """Axis of the mesh that is up: axis of rings, and image up. The front is the next axis (y up: z)."""

    peak_threshold: float = 0.1
    """Smallest accepted fitted peak, in (0, 1]; tau of the sweeps. Noise-free, on a white diffuse surface,
    it is the smallest accepted cosine between the normal and the direction to the laser."""

    std_threshold: float = 1.5
    """Largest accepted fitted width, relative to the width of the stripe that was cast."""

    residual_threshold: float = 0.25
    """Largest accepted root mean square residual of the fit, relative to the fitted peak."""

    resolution: tuple[int, int] = (400, 400)
    """Camera pixels (columns, rows)."""

    field_of_view: float = 45.0
    """Horizontal field of view of the camera, degrees."""

    stripes: int = 400
    """Number of positions of the laser sheet over one sweep."""

    stripe_width: float | None = None
    """Full angle of the sheet's wedge, degrees; ``None`` is 450 / columns, as in the reference."""

    baseline: float = 50.0
    """Distance of the laser from the camera, to the right in the image, mm (at `object_size`)."""

    min_range: float = 70.0
    """Smallest depth swept, and distance of the eye from the object's bounding sphere, mm."""

    max_range: float = 300.0
    """Largest depth swept, mm."""

    object_size: float = 75.0
    """Largest side of the object's bounding box, mm; the unit of the other lengths."""

    bits: int = 8
    """Quantisation of the camera's intensities; 0 for none."""

    noise: float = 0.0
    """Magnitude A of the reference's additive speckle, in [0, 1]; it only darkens."""

    fit: Literal["iterative", "closed"] = "iterative"
    """Peak fit: least squares on intensities, or a weighted parabola through their logarithms."""

    shading: Literal["smooth", "flat"] = "smooth"
    """Normals that reflect light and are reported as true: interpolated vertex normals, or face normals."""

    def __post_init__(self) -> None:
        """Bring sequences from TOML or JSON into tuples and check every value."""
        views = self.views
        if not isinstance(views, int | str):
            object.__setattr__(self, "views", tuple(tuple(float(x) for x in d) for d in views))
        object.__setattr__(self, "resolution", tuple(int(x) for x in self.resolution))
        check_views(self.views)
        _check(self)

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> "ScannerConfig":
        """Build from a mapping, as read from TOML or JSON.

        Raises
        ------
        InputError
            If a key is unknown; the message lists the known ones.
        """
        known = sorted(f.name for f in fields(cls))
        unknown = sorted(set(values) - set(known))
        if unknown:
            raise InputError(f"unknown scanner setting {unknown[0]!r}; known settings are {', '.join(known)}")
        return cls(**values)

    @property
    def half_width(self) -> float:
        """Tangent of half the horizontal field of view."""
        return math.tan(math.radians(self.field_of_view) / 2)

    @property
    def focal(self) -> float:
        """Focal length in pixels."""
        return self.resolution[0] / 2 / self.half_width

    @property
    def wedge(self) -> float:
        """Full angle F of the stripe, radians."""
        width = 450.0 / self.resolution[0] if self.stripe_width is None else self.stripe_width
        return math.radians(width)

    @property
    def sweep(self) -> tuple[float, float]:
        """First and last edge of the swept sheet angles, radians.

        The sheet's angle is 0 along the viewing direction and positive to the image's right.
        """
        edges = [
            math.atan2(side * self.half_width * depth - self.baseline, depth)
            for side in (-1, 1)
            for depth in (self.min_range, self.max_range)
        ]
        return min(edges), max(edges)

    @property
    def step(self) -> float:
        """Angle Delta between stripes, radians."""
        first, last = self.sweep
        return (last - first) / self.stripes


def _check(c: ScannerConfig) -> None:
    """Raise InputError for the first impossible value."""

    def require(ok: bool, name: str, rule: str) -> None:
        if not ok:
            raise InputError(f"scanner setting {name} must {rule}, got {getattr(c, name)!r}")

    require(0 < c.peak_threshold <= 1, "peak_threshold", "lie in (0, 1]")
    require(c.std_threshold > 0, "std_threshold", "be positive")
    require(c.residual_threshold > 0, "residual_threshold", "be positive")
    require(len(c.resolution) == 2 and min(c.resolution) >= 8, "resolution", "be two counts of at least 8")
    require(0 < c.field_of_view < 180, "field_of_view", "lie in (0, 180) degrees")
    require(c.stripes >= 3, "stripes", "be at least 3: a peak has three unknowns")
    require(c.stripe_width is None or 0 < c.stripe_width < 90, "stripe_width", "lie in (0, 90) degrees")
    require(c.baseline != 0, "baseline", "not be 0: without it nothing can be triangulated")
    require(c.min_range > 0, "min_range", "be positive")
    require(c.max_range > c.min_range, "max_range", f"exceed min_range ({c.min_range!r})")
    require(c.object_size > 0, "object_size", "be positive")
    require(0 <= c.bits <= 16, "bits", "lie in 0..16")
    require(0 <= c.noise <= 1, "noise", "lie in [0, 1]")
    require(c.up in ("x", "y", "z"), "up", "be 'x', 'y' or 'z'")
    require(c.fit in ("iterative", "closed"), "fit", "be 'iterative' or 'closed'")
    require(c.shading in ("smooth", "flat"), "shading", "be 'smooth' or 'flat'")
    if 3 * c.step > c.wedge:
        raise InputError(
            f"a stripe of {math.degrees(c.wedge):.3g} degrees is lit in fewer than 3 of the steps of "
            f"{math.degrees(c.step):.3g} degrees; raise stripes (now {c.stripes}) or stripe_width"
        )
