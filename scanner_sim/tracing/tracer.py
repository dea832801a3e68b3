"""What the camera of one view sees: exact hits and the light that returns from them."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.shape import Shape
from scanner_sim.optics.camera import camera_rays, visible_window
from scanner_sim.optics.hits import Hits
from scanner_sim.scanner_config import ScannerConfig
from scanner_sim.tracing import materials, variant
from scanner_sim.tracing.rig_frame import RigFrame
from scanner_sim.tracing.scenes import Renderer, Wavefront, build_mesh
from scanner_sim.tracing.surface_points import barycentrics_on, corner_normals, shading_normals

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
        Values per vertex or face that the material uses.

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
        self.variant = variant.choose() if name is None else name
        self.frame = RigFrame.of(shape, config.object_size)
        self.vertices = self.frame.to_rig(shape.vertices)
        self.normals = corner_normals(shape, config.shading)
        self.attributes = attributes or {}
        materials.check_attributes(shape, self.attributes)
        kind = Renderer if self.variant == variant.SCALAR else Wavefront
        with variant.active(self.variant) as mi:
            numbered = build_mesh(mi, shape, self.vertices, "flat", None) if kind is Renderer else None
            self._scenes: Renderer | Wavefront = kind(mi, config, self.mesh(mi), numbered)

    def mesh(self, mi: Any) -> Any:
        """A new Mitsuba mesh of the shape in the rig, with its material."""
        surface = materials.bsdf(mi, self.config, self.attributes)
        return build_mesh(mi, self.shape, self.vertices, self.config.shading, surface, self.attributes)

    def view(self, pose: NDArray[np.float64]) -> Hits:
        """Trace the camera and shadow rays of one view.

        Parameters
        ----------
        pose : (4, 4)
            Camera-to-rig matrix, mm.

        Returns
        -------
        Hits
        """
        baseline = self.config.baseline
        vertices = (self.vertices - pose[:3, 3]) @ pose[:3, :3]
        window = visible_window(vertices, self.config)
        if window is None:
            return Hits.none()
        with variant.active(self.variant) as mi:
            seen = self._scenes.trace(mi, pose, pose[:3, 3] + baseline * pose[:3, 0], window)
        corners = vertices[self.shape.faces[seen.face_ids]]
        barycentrics, points = barycentrics_on(corners, camera_rays(seen.pixels, self.config))
        toward = np.array([baseline, 0, 0]) - points
        squared = (toward**2).sum(axis=1)
        light = seen.light * squared if seen.falls_off else seen.light
        normals = shading_normals(self.normals, seen.face_ids, barycentrics) @ pose[:3, :3]
        cosine = np.einsum("nd,nd->n", normals, toward) / np.sqrt(squared)
        return Hits(seen.pixels, seen.face_ids, barycentrics, points, normals, rounded(light, cosine))


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
