"""What the camera of one view sees: exact hits and the light that returns from them."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.meshes.geometry import face_normals
from datasets_gen.shape import Shape
from scanner_sim.optics.camera import camera_rays, visible_window
from scanner_sim.optics.hits import Hits
from scanner_sim.scanner_config import ScannerConfig
from scanner_sim.tracing import albedo, background, materials, variant
from scanner_sim.tracing.mitsuba_mesh import build_mesh
from scanner_sim.tracing.rig_frame import RigFrame
from scanner_sim.tracing.scenes import Renderer, Wavefront
from scanner_sim.tracing.surface_points import (
    barycentrics_on,
    bent_normals,
    corner_normals,
    shading_normals,
)

BLACK = 1e-6
"""Least albedo: no paint is quite black, and what is lit is not in shadow."""
REFLECTANCE = 1e-4
"""Step to which reflectance is rounded: far below a grey level."""


class Tracer:
    """Scenes of one shape, built once and used for any number of views.

    Parameters
    ----------
    shape
    config
    name
        Mitsuba variant; the fastest sound one if not given.
    attributes
        Values per vertex or face, or a texture, that the material uses.

    Raises
    ------
    InputError
        If the material or an attribute cannot be used.
    """

    def __init__(
        self,
        shape: Shape,
        config: ScannerConfig,
        name: str | None = None,
        attributes: materials.Attributes | None = None,
    ) -> None:
        self.shape = shape
        self.config = config
        self.fine = with_footprint(config)
        self.variant = variant.choose() if name is None else name
        self.frame = RigFrame.of(shape, config.object_size)
        self.vertices = self.frame.place(shape)
        self.normals = corner_normals(shape, config.shading, config.crease_angle)
        self.face_normals = face_normals(shape.vertices, shape.faces)
        self.attributes = attributes or {}
        materials.check_attributes(shape, self.attributes)
        self._albedo: albedo.AlbedoAt | None = None
        if config.material == albedo.COLOURS:
            self._albedo = albedo.lookup(shape, self.attributes, config.wavelength)
        kind = Renderer if self.variant == variant.SCALAR else Wavefront
        with variant.active(self.variant) as mi:
            numbered = build_mesh(mi, shape, self.vertices, None, None) if kind is Renderer else None
            self._scenes: Renderer | Wavefront = kind(mi, self.fine, self.mesh(mi), numbered)

    def mesh(self, mi: Any) -> Any:
        """A new Mitsuba mesh of the shape in the rig, with its material."""
        surface = materials.bsdf(mi, self.config, self.attributes)
        normals = self.normals if self.config.shading == "smooth" else None
        given = {name: value for name, value in self.attributes.items() if name not in albedo.NAMES}
        return build_mesh(mi, self.shape, self.vertices, normals, surface, given)

    def view(self, pose: NDArray[np.float64], region: NDArray[np.float64] | None = None) -> Hits:
        """Trace the camera and shadow rays of one view.

        Parameters
        ----------
        pose : (4, 4)
            Camera-to-rig matrix, mm.
        region : (r, 3), optional
            Corners of what matters, in camera coordinates: no ray is traced beside it. By default the object.

        Returns
        -------
        Hits
        """
        baseline = self.config.baseline
        vertices = (self.vertices - pose[:3, 3]) @ pose[:3, :3]
        window = visible_window(vertices if region is None else region, self.fine)
        if window is None:
            return Hits.none()
        with variant.active(self.variant) as mi:
            laser = pose[:3, 3] + baseline * pose[:3, 0]
            seen = self._scenes.trace(mi, pose, laser, window)
            corners = vertices[self.shape.faces[seen.face_ids]]
            rays = camera_rays(seen.pixels, self.fine)
            barycentrics, points = barycentrics_on(corners, rays)
            toward = np.array([baseline, 0, 0]) - points
            squared = (toward**2).sum(axis=1)
            light = seen.light * squared if seen.falls_off else seen.light
            normals = shading_normals(self.normals, seen.face_ids, barycentrics) @ pose[:3, :3]
            facets = self.face_normals[seen.face_ids] @ pose[:3, :3]
            normals, bent = bent_normals(normals, facets, -points, toward)
            light[bent] = self._scenes.facet_light(mi, pose[:3, 3], rays[bent] @ pose[:3, :3].T, laser)
            light = np.where(np.einsum("nd,nd->n", facets, toward) > 0, light, 0.0)
            cosine = np.einsum("nd,nd->n", normals, toward) / np.sqrt(squared)
            light = rounded(light, cosine)
            if self._albedo is not None:
                light *= np.maximum(self._albedo(seen.face_ids, barycentrics), BLACK)
            pixels = seen.pixels // np.int32(self.config.footprint)
            hits = Hits(pixels, seen.face_ids, barycentrics, points, normals, light)
            if self.config.background is None:
                return hits
            scene = self._scenes.scene
            return background.with_background(mi, scene, hits, seen.pixels, pose, self.config, self.fine)


def with_footprint(config: ScannerConfig) -> ScannerConfig:
    """The camera with a pixel for every ray of a pixel's footprint: the same image, sampled more finely."""
    if config.footprint == 1:
        return config
    columns, rows = (size * config.footprint for size in config.resolution)
    return replace(config, resolution=(columns, rows), stripe_width=math.degrees(config.wedge))


def rounded(radiance: NDArray[np.float64], cosine: NDArray[np.float64]) -> NDArray[np.float64]:
    """Radiance (n,) without most of its error of single precision.

    Mitsuba's variants differ in the last digits of a radiance: enough to move one stored intensity in some
    hundred points to the next grey level. So only the reflectance, BSDF times pi, is taken from Mitsuba,
    rounded to `REFLECTANCE`; the cosine (n,) between shading normal and direction to the laser is of double
    precision.
    """
    lit = (radiance > 0) & (cosine > 0)
    reflectance = np.divide(radiance, cosine, out=np.zeros_like(radiance), where=lit)
    return np.where(lit, np.round(reflectance / REFLECTANCE) * REFLECTANCE * cosine, radiance)
