"""Mitsuba scenes of a shape, and the two ways to ask them what camera and laser see.

`Renderer` serves every variant: two tiny renders per view, at millions of rays a second in the scalar
variant too. In one the mesh emits the number of each face as light; in the other a point light stands at
the laser, so a pixel's radiance is BSDF times cosine over the squared distance, and 0 where the shadow ray
is blocked. `Wavefront` serves the vectorised variants: arrays of rays through one kernel, compiled once.
Both count a hit where the ray meets the front of a face, whatever its shading normals, and both tell on
request (`facet_light`) what light returns if the normal is the face's.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.meshes.geometry import unit_vectors
from scanner_sim.optics.camera import Window, camera_rays, undistorted
from scanner_sim.scanner_config import ScannerConfig


@dataclass(frozen=True)
class WindowHits:
    """Pixels of a window whose camera ray hits the object.

    Attributes
    ----------
    pixels : (n, 2) int32
        Column and row in the whole image.
    face_ids : (n,) int32
    light : (n,) float64
        BSDF times cosine times pi, divided by the squared distance to the laser if `falls_off`; 0 in shadow
        and where the shading normal faces away from camera or laser.
    falls_off : bool
    """

    pixels: NDArray[np.int32]
    face_ids: NDArray[np.int32]
    light: NDArray[np.float64]
    falls_off: bool


def build_scene(mi: Any, mesh: Any, emitter: dict[str, Any] | None = None) -> Any:
    """Scene of a mesh and, if given, the emitter ``"laser"``; robust for thin features."""
    scene: dict[str, Any] = {"type": "scene", "object": mesh}
    if not mi.variant().startswith("cuda"):  # which traces with OptiX, not Embree
        scene["embree_use_robust_intersections"] = True
    if emitter is not None:
        scene["laser"] = emitter
    return mi.load_dict(scene)


def camera_sensor(
    mi: Any, config: ScannerConfig, pose: NDArray[np.float64], window: Window, paths: int = 1
) -> Any:
    """Pinhole camera that renders a window of the image: one ray through pixel centres, or more all over."""
    flipped = pose @ np.diag([-1.0, -1.0, 1.0, 1.0])  # Mitsuba's camera has x to the left and y up
    film = {
        "type": "hdrfilm",
        "width": config.resolution[0],
        "height": config.resolution[1],
        "crop_offset_x": window[0],
        "crop_offset_y": window[1],
        "crop_width": window[2],
        "crop_height": window[3],
        "pixel_format": "rgb",
        "component_format": "float32",
        "rfilter": {"type": "box"},
    }
    return mi.load_dict(
        {
            "type": "perspective",
            "fov": config.field_of_view,
            "fov_axis": "x",
            "near_clip": 1e-3 * config.min_range,
            "far_clip": 1e3 * config.max_range,
            "to_world": mi.ScalarTransform4f(flipped.tolist()),
            "film": film,
            "sampler": {"type": "stratified", "jitter": paths > 1, "sample_count": paths},
        }
    )


class Renderer:
    """Faces and light by rendering; any variant, meant for the scalar one.

    Parameters
    ----------
    mi
        Mitsuba with its variant set.
    config
    mesh
        With its material.
    face_number_mesh
        The same with face numbers as light (`build_mesh` without a surface).
    """

    def __init__(self, mi: Any, config: ScannerConfig, mesh: Any, face_number_mesh: Any) -> None:
        self.config = config
        point = {"type": "point", "position": [0.0, 0.0, 1000.0], "intensity": 1.0}
        self.scene = build_scene(mi, mesh, point)
        self.faces = build_scene(mi, face_number_mesh)
        self.parameters = mi.traverse(self.scene)
        self.direct = mi.load_dict({"type": "direct", "emitter_samples": 1, "bsdf_samples": 0})
        self.emission = mi.load_dict({"type": "path", "max_depth": 1})

    def trace(
        self, mi: Any, pose: NDArray[np.float64], laser: NDArray[np.float64], window: Window
    ) -> WindowHits:
        """Trace the pixels of a window; `laser` is the (3,) position in the rig."""
        if any(self.config.distortion):
            return self._one_by_one(mi, pose, laser, window)
        camera = camera_sensor(mi, self.config, pose, window)
        self.parameters["laser.position"] = laser.tolist()
        self.parameters.update()
        number = np.array(self.emission.render(self.faces, sensor=camera, spp=1))[..., 0]
        light = np.array(self.direct.render(self.scene, sensor=camera, spp=1))[..., 0]
        row, column = np.nonzero(number)
        pixels = np.stack([column + window[0], row + window[1]], axis=1).astype(np.int32)
        returned = np.pi * light[row, column].astype(np.float64)
        return WindowHits(pixels, number[row, column].astype(np.int32) - 1, returned, falls_off=True)

    def _one_by_one(
        self, mi: Any, pose: NDArray[np.float64], laser: NDArray[np.float64], window: Window
    ) -> WindowHits:
        """Trace rays that no Mitsuba sensor has; some 20 microseconds each."""
        column, row = np.meshgrid(np.arange(window[2]) + window[0], np.arange(window[3]) + window[1])
        pixels = np.stack([column.ravel(), row.ravel()], axis=1).astype(np.int32)
        toward = camera_rays(pixels, self.config) @ pose[:3, :3].T
        faces, light = np.zeros(len(pixels), np.int32), np.zeros(len(pixels))
        for k, hit in self._hits(mi, pose[:3, 3], toward):
            faces[k] = hit.prim_index + 1
            light[k] = self._returned(mi, hit, laser)
        kept = np.flatnonzero(faces)
        return WindowHits(pixels[kept], faces[kept] - 1, light[kept], falls_off=False)

    def _hits(
        self, mi: Any, eye: NDArray[np.float64], toward: NDArray[np.float64]
    ) -> Iterator[tuple[int, Any]]:
        """Number of each ray that meets the front of a face, and where."""
        origin = mi.Point3f(eye.tolist())
        for k, direction in enumerate(unit_vectors(toward).tolist()):
            ray = mi.Ray3f(origin, mi.Vector3f(direction))
            hit = self.scene.ray_intersect(ray)
            if hit.is_valid() and np.dot(hit.n, ray.d) < 0:
                yield k, hit

    def _returned(self, mi: Any, hit: Any, laser: NDArray[np.float64]) -> float:
        """BSDF times cosine times pi at a hit; 0 in shadow."""
        place = mi.Point3f(laser.tolist())
        if self.scene.ray_test(hit.spawn_ray_to(place)):
            return 0.0
        away = place - hit.p
        wanted = hit.to_local(away / float(np.linalg.norm(np.array(away))))
        return float(np.pi * hit.bsdf().eval(mi.BSDFContext(), hit, wanted)[0])

    def facet_light(
        self, mi: Any, eye: NDArray[np.float64], toward: NDArray[np.float64], laser: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Light that returns along rays if the surface reflects with the normals of its faces.

        Parameters
        ----------
        mi
            Mitsuba with its variant set.
        eye, laser : (3,)
            In the rig.
        toward : (n, 3)
            Directions of the rays.

        Returns
        -------
        (n,) float64
            BSDF times cosine times pi; 0 in shadow.
        """
        light = np.zeros(len(toward))
        for k, hit in self._hits(mi, eye, toward):
            back = mi.Vector3f(unit_vectors(-toward[k]).tolist())
            hit.sh_frame.n = hit.n
            hit.initialize_sh_frame()
            hit.wi = hit.to_local(back)
            light[k] = self._returned(mi, hit, laser)
        return light


class Wavefront:
    """Faces and light by arrays of rays; LLVM and CUDA variants. Parameters as in `Renderer`."""

    def __init__(self, mi: Any, config: ScannerConfig, mesh: Any, face_number_mesh: Any = None) -> None:
        self.config = config
        self.scene = build_scene(mi, mesh)

    def trace(
        self, mi: Any, pose: NDArray[np.float64], laser: NDArray[np.float64], window: Window
    ) -> WindowHits:
        """Trace the pixels of a window; `laser` is the (3,) position in the rig."""
        import drjit as dr

        width, height = self.config.resolution
        focal = self.config.focal
        # a table, not literals: literals would be compiled into the kernel, anew for each view
        numbers = [*pose[:3].ravel(), *laser, (0.5 + window[0] - width / 2) / focal]
        numbers += [(0.5 + window[1] - height / 2) / focal, 1 / focal, *self.config.distortion]
        table = mi.Float([float(x) for x in numbers])
        size = window[2] * window[3]
        values = [dr.gather(mi.Float, table, dr.full(mi.UInt32, k, size)) for k in range(len(numbers))]
        columns = dr.opaque(mi.UInt32, window[2])
        m, place, (x0, y0, pitch, k1, k2) = values[:12], mi.Point3f(values[12:15]), values[15:]
        index = dr.arange(mi.UInt32, size)
        row = index // columns
        x = x0 + pitch * mi.Float(index - row * columns)
        y = y0 + pitch * mi.Float(row)
        if any(self.config.distortion):
            x, y = undistorted(x, y, k1, k2)
        toward = mi.Vector3f(*(m[4 * k] * x + m[4 * k + 1] * y + m[4 * k + 2] for k in range(3)))
        ray = mi.Ray3f(mi.Point3f(m[3], m[7], m[11]), dr.normalize(toward))
        hit = self.scene.ray_intersect(ray)
        found = hit.is_valid() & (dr.dot(hit.n, ray.d) < 0)
        light = self._returned(mi, ray, hit, place, found)
        number = dr.select(found, hit.prim_index + 1, 0)
        dr.eval(light, number)
        faces = np.array(number).astype(np.int32)
        kept = np.flatnonzero(faces)
        pixels = np.stack([kept % window[2] + window[0], kept // window[2] + window[1]], axis=1)
        received = np.array(light)[kept].astype(np.float64)
        return WindowHits(pixels.astype(np.int32), faces[kept] - 1, received, falls_off=False)

    def _returned(self, mi: Any, ray: Any, hit: Any, place: Any, found: Any) -> Any:
        """BSDF times cosine times pi at hits of rays, with the laser at a place; 0 in shadow."""
        import drjit as dr

        wanted = hit.to_local(dr.normalize(place - hit.p))
        free = found & ~self.scene.ray_test(hit.spawn_ray_to(place), found)
        returned = hit.bsdf(ray).eval(mi.BSDFContext(), hit, wanted, free)[0]
        return dr.select(free, returned * dr.pi, 0)

    def facet_light(
        self, mi: Any, eye: NDArray[np.float64], toward: NDArray[np.float64], laser: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """As `Renderer.facet_light`."""
        if len(toward) == 0:  # arrays of no rays abort Dr.Jit
            return np.zeros(0)
        import drjit as dr

        def opaque(place: NDArray[np.float64]) -> Any:
            return mi.Point3f(*(dr.opaque(mi.Float, float(x)) for x in place))

        ray = mi.Ray3f(opaque(eye), mi.Vector3f(unit_vectors(toward).T.astype(np.float32)))
        hit = self.scene.ray_intersect(ray)
        hit.sh_frame.n = hit.n
        hit.initialize_sh_frame()
        hit.wi = hit.to_local(-ray.d)
        light = self._returned(mi, ray, hit, opaque(laser), hit.is_valid() & (hit.wi.z > 0))
        return np.array(light).astype(np.float64)
