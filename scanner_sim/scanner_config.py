"""Parameters of the scanner, in millimetres for an object whose largest side is `object_size`."""

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Literal, get_args, get_origin, get_type_hints

from datasets_gen.records import InputError
from scanner_sim.optics.viewpoints import Views, check_views


@dataclass(frozen=True, kw_only=True)
class ScannerConfig:
    """Everything that decides a scan but the shape, its attributes and the seed.

    The rig is built for an object whose largest bounding-box side measures `object_size` millimetres and
    is scaled to the mesh, so results do not depend on the mesh's units.

    Raises
    ------
    InputError
        If a value is impossible; the message names the field, the value and the remedy.
    """

    # the rig
    views: Views = 10
    """Viewpoints: a count (near-uniform on the sphere), ``"sphere:N"``, ``"ring:N"`` (about `up`),
    ``"opposed"`` (front and back), or directions ``((x, y, z), ...)`` from the object's centre."""
    up: Literal["x", "y", "z"] = "y"
    """Axis of the mesh that is up: axis of rings, and image up. The front is the next axis (y up: z)."""
    distance: float | None = None
    """Distance of the eyes from the object's centre, mm; None: `min_range` + half the diagonal."""
    resolution: tuple[int, int] = (400, 400)
    """Camera pixels (columns, rows)."""
    field_of_view: float = 45.0
    """Horizontal field of view of the camera, degrees."""
    distortion: tuple[float, float] = (0.0, 0.0)
    """Radial distortion (k1, k2) of the lens; slow in the scalar variant if not zero."""
    baseline: float = 50.0
    """Distance of the laser from the camera, to the right in the image, mm."""
    min_range: float = 70.0
    """Smallest depth swept, and distance of the eye from the object's bounding sphere, mm."""
    max_range: float = 300.0
    """Largest depth swept, mm."""
    object_size: float = 75.0
    """Largest side of the object's bounding box, mm; the unit of the other lengths."""

    # the light
    stripes: int = 400
    """Number of positions of the laser sheet over one sweep."""
    beam: Literal["wedge", "gaussian"] = "wedge"
    """Profile across the sheet: the reference's wedge, or a Gaussian beam that diverges from its waist."""
    stripe_width: float | None = None
    """Full angle of the wedge, degrees; None: 450 / columns, as in the reference."""
    beam_waist: float = 0.5
    """Smallest 1/e^2 radius of the Gaussian beam, at about the distance of the object's centre, mm."""
    wavelength: float = 650.0
    """Of the Gaussian beam's divergence, nm."""
    falloff: Literal["none", "inverse_square"] = "none"
    """Irradiance over distance: constant as in the reference, or 1/r^2 with 1 at the nearest depth swept."""
    smoothing: float = 0.0
    """Gaussian blur of each stripe's image, standard deviation in pixels (the reference's laser smoother)."""

    # the surface
    material: str | Mapping[str, Any] = field(default="white", hash=False)
    """A name of `scanner_sim.MATERIALS` or a Mitsuba BSDF as a table, such as
    ``{type = "roughplastic", alpha = 0.2}``."""
    shading: Literal["smooth", "flat"] = "smooth"
    """Normals that reflect light and are reported as true: interpolated vertex normals, or face normals."""
    bounces: int = 1
    """Reflections followed from the laser to the camera. More than 1 adds the light of path tracing under
    every stripe: for validation, thousands of times slower."""

    # the camera's sensor
    noise: float = 0.0
    """Magnitude A of the reference's additive speckle, in [0, 1]; it only darkens."""
    exposure: float = 1.0
    """Light collected, relative to a white surface that faces the laser reading 1."""
    full_well: int = 0
    """Electrons at intensity 1, which set the shot noise; 0: no shot noise."""
    read_noise: float = 0.0
    """Standard deviation of the noise of reading out, in intensities before `gain`."""
    gain: float = 1.0
    """Amplification after shot and read noise; lifts dark materials up to saturation at 1."""
    bits: int = 8
    """Quantisation of the camera's intensities; 0 for none."""

    # from intensities to points
    fit: Literal["iterative", "closed"] = "iterative"
    """Peak fit: least squares on intensities, or a weighted parabola through their logarithms."""
    peak_threshold: float = 0.1
    """Smallest accepted fitted peak, in (0, 1]; tau of the sweeps. Noise-free, on a white diffuse surface,
    it is the smallest accepted cosine between the normal and the direction to the laser."""
    std_threshold: float = 1.5
    """Largest accepted fitted width, relative to the width of the stripe that was cast."""
    residual_threshold: float = 0.15
    """Largest accepted root mean square residual of the fit, relative to the fitted peak."""
    depth_threshold: float | None = None
    """Largest accepted distance to the true point, mm; None: any. The reference uses 4, but a real scanner
    does not know the truth."""
    registration_error: float = 0.0
    """Angle by which each view is turned about its centroid, about a random axis, degrees."""
    realign: bool = False
    """Re-align the views by ICP."""
    normals: Literal["true", "pca", "mst"] = "true"
    """True ones; PCA within each view with the sign from the scanner; PCA with signs by a spanning tree."""
    neighbours: int = 12
    """Points of a PCA, the point itself not counted."""

    def __post_init__(self) -> None:
        """Bring sequences from TOML or JSON into tuples and check every value."""
        if not isinstance(self.views, int | str):
            check_views(self.views)
            object.__setattr__(self, "views", tuple(tuple(float(x) for x in d) for d in self.views))
        check_views(self.views)
        for name in ("resolution", "distortion"):
            value = getattr(self, name)
            if isinstance(value, list):
                object.__setattr__(self, name, tuple(value))
        _check_types(self)
        _check_values(self)

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
    def nearest(self) -> float:
        """Distance of the laser from the nearest depth swept, on the camera's axis, mm."""
        return math.hypot(self.min_range, self.baseline)

    @property
    def focus(self) -> float:
        """Distance of the laser from an object of average proportions, where the beam has its waist, mm."""
        depth = self.min_range + self.object_size / 2 if self.distance is None else self.distance
        return math.hypot(depth, self.baseline)

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


_LENGTHS = ("object_size", "min_range", "beam_waist", "wavelength")
_POSITIVE = (*_LENGTHS, "exposure", "gain", "std_threshold", "residual_threshold")
_Rule = tuple[str, Callable[[ScannerConfig], bool], str]
_RULES: list[_Rule] = [
    *[(name, lambda c, name=name: getattr(c, name) > 0, "be positive") for name in _POSITIVE],
    ("resolution", lambda c: min(c.resolution) >= 8, "be at least (8, 8)"),
    ("field_of_view", lambda c: 0 < c.field_of_view < 180, "lie in (0, 180) degrees"),
    ("distortion", lambda c: _invertible(c), "be weak enough to be inverted within the image"),
    ("baseline", lambda c: c.baseline != 0, "not be 0: without a baseline nothing can be triangulated"),
    ("max_range", lambda c: c.max_range > c.min_range, "exceed min_range"),
    ("distance", lambda c: c.distance is None or c.distance > 0, "be positive"),
    ("stripes", lambda c: c.stripes >= 3, "be at least 3: a peak has three unknowns"),
    ("stripe_width", lambda c: c.stripe_width is None or 0 < c.stripe_width < 90, "lie in (0, 90) degrees"),
    ("smoothing", lambda c: 0 <= c.smoothing <= 10, "lie in [0, 10] pixels"),
    ("bounces", lambda c: c.bounces >= 1, "be at least 1"),
    (
        "bounces",
        lambda c: c.bounces == 1 or _renderable(c),
        "be 1 unless falloff is 'inverse_square', beam 'wedge', and smoothing and distortion are 0",
    ),
    ("noise", lambda c: 0 <= c.noise <= 1, "lie in [0, 1]"),
    ("full_well", lambda c: c.full_well >= 0, "not be negative"),
    ("read_noise", lambda c: c.read_noise >= 0, "not be negative"),
    ("bits", lambda c: 0 <= c.bits <= 16, "lie in 0..16"),
    ("peak_threshold", lambda c: 0 < c.peak_threshold <= 1, "lie in (0, 1]"),
    ("depth_threshold", lambda c: c.depth_threshold is None or c.depth_threshold > 0, "be positive"),
    ("registration_error", lambda c: 0 <= c.registration_error <= 45, "lie in [0, 45] degrees"),
    ("neighbours", lambda c: c.neighbours >= 3, "be at least 3"),
]


def _renderable(config: ScannerConfig) -> bool:
    """Whether Mitsuba's own emitters and sensors can render the stripes."""
    physical = config.falloff == "inverse_square" and config.beam == "wedge"
    return physical and config.smoothing == 0 and not any(config.distortion)


def _invertible(config: ScannerConfig) -> bool:
    """Whether the distorted radius grows with the radius, over the image and some way beyond."""
    k1, k2 = config.distortion
    corner = 1.5 * math.hypot(*config.resolution) / 2 / config.focal
    squares = [(corner * i / 64) ** 2 for i in range(65)]
    return all(1 + 3 * k1 * s + 5 * k2 * s * s > 0.3 for s in squares)


def _check_types(config: ScannerConfig) -> None:
    """Raise InputError for values of another type or, where there are choices, another word."""
    for name, hint in get_type_hints(ScannerConfig).items():
        value = getattr(config, name)
        if name in ("views", "material"):
            continue
        if get_origin(hint) is Literal:
            ok, wanted = value in get_args(hint), f"one of {', '.join(map(repr, get_args(hint)))}"
        elif get_origin(hint) is tuple:
            kind = get_args(hint)[0]
            ok = isinstance(value, tuple) and len(value) == 2 and all(_is(kind, x) for x in value)
            wanted = f"two {'whole numbers' if kind is int else 'numbers'}"
        else:
            kinds = get_args(hint) or (hint,)
            ok, wanted = any(_is(kind, value) for kind in kinds), _WANTED[kinds[0]]
        if not ok:
            raise InputError(f"scanner setting {name} must be {wanted}, got {value!r}")


_WANTED: dict[Any, str] = {bool: "true or false", int: "a whole number", float: "a finite number"}


def _is(kind: Any, value: object) -> bool:
    """Whether a value may stand for a type: whole numbers are numbers, truth values are not."""
    if kind in (int, float) and isinstance(value, bool):
        return False
    if kind is float:
        return isinstance(value, int | float) and math.isfinite(value)
    return isinstance(value, kind)


def _check_values(config: ScannerConfig) -> None:
    """Raise InputError for the first impossible value."""
    for name, holds, rule in _RULES:
        if not holds(config):
            raise InputError(f"scanner setting {name} must {rule}, got {getattr(config, name)!r}")
    if config.beam == "wedge" and 3 * config.step > config.wedge:
        raise InputError(
            f"a stripe of {math.degrees(config.wedge):.3g} degrees is lit in fewer than 3 of the steps of "
            f"{math.degrees(config.step):.3g} degrees; raise stripes (now {config.stripes}) or stripe_width"
        )
    try:
        json.dumps(config.material)
    except (TypeError, ValueError) as error:
        raise InputError(
            f"scanner setting material must be a name or a table of plain values: {error}"
        ) from error
