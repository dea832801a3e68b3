"""Parameters of the scanner, in millimetres for an object whose largest side is `object_size`."""

import math
import os
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Literal

from datasets_gen.records import InputError
from datasets_gen.values import check_types, did_you_mean
from scanner_sim.optics.viewpoints import Views, as_tuples, check_views
from scanner_sim.presets import expanded
from scanner_sim.scanner_rules import check_values


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
    ``"opposed"`` (front and back), ``"turntable:N"`` or ``"turntable:N@ELEVATION"`` (degrees), ``"front:N"``,
    ``"back:N"``, ``"left:N"`` or ``"right:N"`` (1 to 3 cameras on one side), directions ``((x, y, z), ...)``
    from the object's centre, or 4 x 4 camera-to-mesh matrices."""
    up: Literal["x", "y", "z"] = "y"
    """Axis of the mesh that is up: axis of rings, and image up. The front is the next axis (y up: z),
    the left of what faces the front the one after it (y up: x)."""
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
    """Smallest distance from the eye that is swept, along the rays at the image's edges, as in the reference;
    and distance of the eye from the object's bounding sphere, mm."""
    max_range: float = 300.0
    """Largest distance from the eye that is swept, along the rays at the image's edges, mm."""
    object_size: float = 75.0
    """Largest side of the object's bounding box, mm; the unit of the other lengths."""
    cameras: Literal[1, 2] = 1
    """2: a second camera on the other side of the laser, turned to the object as the first one is."""

    # motion
    motion: Literal["sweep", "profiler"] = "sweep"
    """How the sheet crosses the object: it turns while camera and object stand still, or it stands still in
    a rig that moves past the object and measures one profile per frame."""
    profile_step: float = 0.25
    """Profiler: travel of the rig between two frames, mm."""
    part_velocity: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Profiler: motion of the object that nobody corrects for, mm per frame, in camera coordinates."""

    # errors of calibration: the rig has them, the triangulation does not know
    focal_error: float = 0.0
    """Relative error of the assumed focal length."""
    principal_point_error: tuple[float, float] = (0.0, 0.0)
    """Error of the assumed principal point, pixels."""
    baseline_error: float = 0.0
    """Error of the assumed baseline, mm."""
    sheet_error: float = 0.0
    """Error of the assumed sheet angle, degrees."""

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
    """Of the laser, nm: decides how a Gaussian beam diverges, and which of a mesh's colours it sees."""
    falloff: Literal["none", "inverse_square"] = "none"
    """Irradiance over distance: constant as in the reference, or 1/r^2 with 1 at the nearest depth swept."""
    smoothing: float = 0.0
    """Gaussian blur of each stripe's image, standard deviation in pixels. The reference's laser smoother s
    has the kernel exp(-2 x^2 / s^2): its s is twice this."""
    smoothing_stage: Literal["light", "image"] = "light"
    """What is blurred: the light before it reaches the sensor, as a lens does, or the stored image after
    noise and quantisation, as the reference does."""
    footprint: int = 1
    """Rays per pixel and axis, an odd number: with more than one, a pixel gathers light from all of its area,
    so that depth edges mix. 1: through pixel centres, as in the reference."""
    ambient: float = 0.0
    """Light of the room, relative to the laser's peak on a white surface that faces it."""

    # the surface
    material: str | Mapping[str, Any] = field(default="white", hash=False)
    """A name of `scanner_sim.MATERIALS` or a Mitsuba BSDF as a table, such as
    ``{type = "roughplastic", alpha = 0.2}``; ``"colours"`` takes the mesh's own colours or texture as
    albedo at the laser's wavelength."""
    shading: Literal["smooth", "flat"] = "smooth"
    """Normals that reflect light and are reported as true: interpolated vertex normals, or face normals."""
    crease_angle: float = 60.0
    """Smooth shading: edges whose faces turn by more than this are sharp, degrees; 180: none is."""
    translucency: float = 0.0
    """Mean depth from which light returns below the surface, mm; 0: opaque."""
    refractive_index: float = 1.5
    """Of a translucent surface."""
    background: float | None = None
    """Distance of a white plane behind the object's centre, as the camera sees it, mm; None: no plane. It
    hides nothing but mixes with the object at silhouettes; its own points are dropped."""
    bounces: int = 1
    """Reflections followed from the laser to the camera. More than 1 adds the light of path tracing under
    every stripe: for validation, thousands of times slower."""

    # the camera's sensor
    noise: float = 0.0
    """Magnitude A of the reference's additive speckle, in [0, 1]; it only darkens."""
    speckle_contrast: float = 0.0
    """Contrast (standard deviation over mean) of multiplicative laser speckle; 1: fully developed."""
    speckle_size: float = 1.0
    """Correlation length of multiplicative speckle on the sensor, pixels."""
    exposure: float = 1.0
    """Light collected, relative to a white surface that faces the laser reading 1."""
    full_well: int = 0
    """Electrons at intensity 1, which set the shot noise; 0: no shot noise."""
    read_noise: float = 0.0
    """Standard deviation of the noise of reading out, in intensities before `gain`."""
    gain: float = 1.0
    """Amplification after shot and read noise; lifts dark materials up to saturation at 1."""
    dark_level: float = 0.0
    """Intensity stored without any light; known, and subtracted before peaks are fitted."""
    bits: int = 8
    """Quantisation of the camera's intensities; 0 for none."""
    quantisation: Literal["round", "truncate"] = "round"
    """To the nearest level, or to the one below, as in the reference."""

    # from intensities to points
    fit: Literal["reference", "least_squares", "gaussian", "centre_of_mass", "parabola", "fir", "steger"] = (
        "reference"
    )
    """Peak detector (`scanner_sim.optics.peak`). ``"reference"``: that of [BLN*11], whose largest sample is
    the peak that `peak_threshold` means; ``"least_squares"``: a Gaussian with saturated samples censored;
    the others are the usual detectors of laser lines."""
    peak_threshold: float = 0.1
    """Smallest accepted fitted peak, in (0, 1]; tau of the sweeps. Noise-free, on a white diffuse surface,
    it is the smallest accepted cosine between the normal and the direction to the laser."""
    std_threshold: float = 1.5
    """Largest accepted fitted width, relative to the width of the stripe that was cast and blurred; with the
    reference's fit, relative to half of `stripe_width`."""
    residual_threshold: float = 0.15
    """Largest accepted root mean square residual of the fit, relative to the fitted peak. Not used by the
    reference's fit, which accepts half a sum of squares up to 0.1."""
    depth_threshold: float | None = None
    """Largest accepted distance to the true point, mm; None: any. The reference uses 4, but a real scanner
    does not know the truth."""
    registration_error: float = 0.0
    """Angle by which each view is turned about its centroid, about a random axis, degrees."""
    realign: bool = False
    """Re-align the views by ICP."""
    normals: Literal["true", "pca", "pca_merged", "pca_true_sign", "mst"] = "true"
    """True ones; PCA within each view, or over the points of all views, with the sign from the scanner; the
    latter with the sign of the true normal, as in the reference; PCA over all views with signs by a spanning
    tree, whose side as a whole the scanner decides."""
    neighbours: int = 12
    """Points of a PCA, the point itself not counted."""

    def __post_init__(self) -> None:
        """Bring sequences from TOML or JSON into tuples and check every value."""
        if not isinstance(self.views, int | str):
            check_views(self.views)
            object.__setattr__(self, "views", as_tuples(self.views))
        check_views(self.views)
        for name in ("resolution", "distortion", "principal_point_error", "part_velocity"):
            value = getattr(self, name)
            if isinstance(value, list):
                object.__setattr__(self, name, tuple(value))
        plain = {name: value for name, value in vars(self).items() if name not in ("views", "material")}
        check_types(type(self), plain, "scanner setting")
        check_values(self)

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> "ScannerConfig":
        """Build from a mapping, as read from TOML or JSON; ``preset`` names a preset to start from.

        Raises
        ------
        InputError
            If a key is unknown; the message lists the known ones.
        """
        known = sorted(f.name for f in fields(cls))
        settings = expanded(values, known)
        unknown = sorted(set(settings) - set(known))
        if unknown:
            raise InputError(
                f"unknown scanner setting {unknown[0]!r}{did_you_mean(unknown[0], known)} known settings are "
                f"{', '.join(known)}"
            )
        return cls(**settings)

    @classmethod
    def preset(cls, name: str | os.PathLike[str], **changes: Any) -> "ScannerConfig":
        """The scanner of a preset (`scanner_sim.presets`) or a ``.toml`` file, with some settings changed."""
        return cls.from_dict({"preset": name, **changes})

    @classmethod
    def reference(cls, **changes: Any) -> "ScannerConfig":
        """The reference program of [BLN*11] as it was measured, with some settings changed."""
        return cls.preset("reference", **changes)

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
        depths = [reach / math.hypot(1, self.half_width) for reach in (self.min_range, self.max_range)]
        edges = [
            math.atan2(side * self.half_width * depth - self.baseline, depth)
            for side in (-1, 1)
            for depth in depths
        ]
        return min(edges), max(edges)

    @property
    def step(self) -> float:
        """Angle Delta between stripes, radians."""
        first, last = self.sweep
        return (last - first) / self.stripes
