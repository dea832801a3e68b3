"""What camera and laser see: faces hit by camera rays and the light they return, by Mitsuba 3.

Two tiny renders per view serve every variant, scalar included, at millions of rays a second:

* *faces*: the mesh glows with the number of each face, and emission seen directly is rendered;
* *light*: a point light stands at the laser. A pixel's radiance is BSDF times cosine over the squared
  distance, and 0 where the shadow ray to the laser is blocked.

The exact hit follows in double precision from the camera ray and the plane of the face.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.shape import Shape
from scanner_sim import variant
from scanner_sim.config import ScannerConfig


@dataclass(frozen=True)
class Frame:
    """Placement of the rig: mesh coordinates x are ``scale * (x - center)`` millimetres.

    Attributes
    ----------
    center : (3,) float64
        Centre of the mesh's bounding box, in mesh units.
    scale : float
        Millimetres per mesh unit.
    diagonal : float
        Of the bounding box, mm.
    """

    center: NDArray[np.float64]
    scale: float
    diagonal: float

    @classmethod
    def of(cls, shape: Shape, object_size: float) -> "Frame":
        """Place the rig so that the largest side of the shape measures `object_size` mm."""
        low, high = shape.vertices.min(axis=0), shape.vertices.max(axis=0)
        scale = object_size / float((high - low).max())
        return cls((low + high) / 2, scale, scale * float(np.linalg.norm(high - low)))

    def to_rig(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mesh coordinates to mm."""
        return (points - self.center) * self.scale

    def to_mesh(self, points: NDArray[np.float64]) -> NDArray[np.float64]:
        """Mm to mesh coordinates."""
        return points / self.scale + self.center


@dataclass(frozen=True)
class Hits:
    """Camera rays of one view that hit the object.

    Attributes
    ----------
    pixels : (n, 2) int32
        Column and row.
    face_ids : (n,) int32
    barycentrics : (n, 3) float64
    points : (n, 3) float64
        Hits in camera coordinates, mm (x right, y down, z forward).
    radiance : (n,) float64
        BSDF times cosine times pi towards the camera: for a white diffuse surface the cosine between normal
        and direction to the laser; 0 in shadow.
    """

    pixels: NDArray[np.int32]
    face_ids: NDArray[np.int32]
    barycentrics: NDArray[np.float64]
    points: NDArray[np.float64]
    radiance: NDArray[np.float64]


def vertex_normals(shape: Shape) -> NDArray[np.float64]:
    """Unit normals of the vertices, faces weighted by their angle there, (v, 3)."""
    corners = shape.vertices[shape.faces]  # (f, 3, 3)
    normals = face_normals(shape)
    out = np.zeros_like(shape.vertices)
    for k in range(3):
        a = corners[:, (k + 1) % 3] - corners[:, k]
        b = corners[:, (k + 2) % 3] - corners[:, k]
        angle = np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.einsum("fd,fd->f", a, b))
        for d in range(3):
            out[:, d] += np.bincount(shape.faces[:, k], angle * normals[:, d], minlength=len(out))
    return _unit(out)


def face_normals(shape: Shape) -> NDArray[np.float64]:
    """Unit normals of the faces, (f, 3)."""
    a, b, c = (shape.vertices[shape.faces[:, k]] for k in range(3))
    return _unit(np.cross(b - a, c - a))


def shading_normals(
    shape: Shape, face_ids: NDArray[np.integer], barycentrics: NDArray[np.float64], shading: str
) -> NDArray[np.float64]:
    """Unit normals at surface points: interpolated (``"smooth"``) or of the face (``"flat"``), (n, 3)."""
    if shading == "flat":
        return face_normals(shape)[face_ids]
    return _unit(np.einsum("nc,ncd->nd", barycentrics, vertex_normals(shape)[shape.faces[face_ids]]))


def _unit(vectors: NDArray[np.float64]) -> NDArray[np.float64]:
    """Vectors scaled to length 1; zero vectors stay."""
    length = np.linalg.norm(vectors, axis=-1, keepdims=True)
    return vectors / np.where(length > 0, length, 1)


def barycentrics_on(
    corners: NDArray[np.float64], rays: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Meet rays from the origin with the planes of triangles.

    Parameters
    ----------
    corners : (n, 3, 3)
        Triangles in camera coordinates.
    rays : (n, 3)
        Directions.

    Returns
    -------
    barycentrics : (n, 3)
        Clipped to the triangle: single-precision tracing may choose its neighbour at an edge.
    points : (n, 3)
        The points they stand for.
    """
    a, b, c = corners[:, 0], corners[:, 1], corners[:, 2]
    normals = (np.cross(b, c), np.cross(c, a), np.cross(a, b))
    volumes = np.stack([np.einsum("nd,nd->n", rays, normal) for normal in normals], axis=1)
    total = volumes.sum(axis=1, keepdims=True)
    weights = np.clip(volumes / np.where(total == 0, 1, total), 0, 1)
    sums = weights.sum(axis=1, keepdims=True)
    weights = np.where(sums > 0, weights / np.where(sums > 0, sums, 1), 1 / 3)
    return weights, np.einsum("nc,ncd->nd", weights, corners)


class Tracer:
    """Scenes of one shape, built once and used for any number of views.

    Parameters
    ----------
    shape
    config
    """

    def __init__(self, shape: Shape, config: ScannerConfig) -> None:
        self.shape = shape
        self.config = config
        self.frame = Frame.of(shape, config.object_size)
        self.vertices = self.frame.to_rig(shape.vertices)
        with variant.active() as mi:
            self._light = _scene(mi, self._mesh(mi, glow=False), light=True)
            self._faces = _scene(mi, self._mesh(mi, glow=True), light=False)
            self._light_parameters = mi.traverse(self._light)
            self._direct = mi.load_dict({"type": "direct", "emitter_samples": 1, "bsdf_samples": 0})
            self._emission = mi.load_dict({"type": "path", "max_depth": 1})

    def _mesh(self, mi: Any, *, glow: bool) -> Any:
        """Mitsuba's mesh: with the material, or glowing with face numbers counted from 1."""
        faces = self.shape.faces
        properties = mi.Properties()
        if glow:
            number = {"type": "mesh_attribute", "name": "face_number"}
            properties["emitter"] = mi.load_dict({"type": "area", "radiance": number})
        else:
            white = {"type": "rgb", "value": 1.0}
            properties["bsdf"] = mi.load_dict({"type": "diffuse", "reflectance": white})
        smooth = self.config.shading == "smooth" and not glow
        properties["face_normals"] = not smooth
        mesh = mi.Mesh("object", len(self.vertices), len(faces), has_vertex_normals=smooth, props=properties)
        if glow:
            mesh.add_attribute("face_number", 1, np.arange(1, len(faces) + 1, dtype=np.float32))
        parameters = mi.traverse(mesh)
        parameters["vertex_positions"] = self.vertices.astype(np.float32).ravel()
        parameters["faces"] = faces.astype(np.uint32).ravel()
        if smooth:
            parameters["vertex_normals"] = vertex_normals(self.shape).astype(np.float32).ravel()
        parameters.update()
        return mesh

    def view(self, pose: NDArray[np.float64]) -> Hits:
        """Trace the camera and shadow rays of one view.

        Parameters
        ----------
        pose : (4, 4)
            Camera-to-rig matrix, mm.
        """
        config = self.config
        laser = pose[:3, 3] + config.baseline * pose[:3, 0]
        inverse = pose[:3, :3].T
        vertices = (self.vertices - pose[:3, 3]) @ inverse.T
        window = _window(vertices, config)
        if window is None:
            return _no_hits()
        with variant.active() as mi:
            sensor = _sensor(mi, config, pose, window)
            self._light_parameters["laser.position"] = laser.tolist()
            self._light_parameters.update()
            number = np.array(self._emission.render(self._faces, sensor=sensor, spp=1))[..., 0]
            light = np.array(self._direct.render(self._light, sensor=sensor, spp=1))[..., 0]
        row, column = np.nonzero(number)
        face_ids = number[row, column].astype(np.int32) - 1
        pixels = np.stack([column + window[0], row + window[1]], axis=1).astype(np.int32)
        corners = vertices[self.shape.faces[face_ids]]
        barycentrics, points = barycentrics_on(corners, camera_rays(pixels, config))
        squared = ((points - [config.baseline, 0, 0]) ** 2).sum(axis=1)
        radiance = light[row, column].astype(np.float64) * squared * np.pi
        return Hits(pixels, face_ids, barycentrics, points, radiance)


def camera_rays(pixels: NDArray[np.integer], config: ScannerConfig) -> NDArray[np.float64]:
    """Directions through pixel centres in camera coordinates, with depth 1, (n, 3)."""
    width, height = config.resolution
    x = (pixels[:, 0] + 0.5 - width / 2) / config.focal
    y = (pixels[:, 1] + 0.5 - height / 2) / config.focal
    return np.stack([x, y, np.ones(len(pixels))], axis=1)


def _window(vertices: NDArray[np.float64], config: ScannerConfig) -> tuple[int, int, int, int] | None:
    """Part of the image that can show the object: first column and row, columns and rows."""
    size = np.array(config.resolution)
    if (vertices[:, 2] <= 1e-6).any():
        return 0, 0, int(size[0]), int(size[1])
    image = vertices[:, :2] / vertices[:, 2:] * config.focal + size / 2
    low = np.clip(np.floor(image.min(axis=0)).astype(int) - 1, 0, size)
    high = np.clip(np.ceil(image.max(axis=0)).astype(int) + 1, 0, size)
    if (high <= low).any():
        return None
    return int(low[0]), int(low[1]), int(high[0] - low[0]), int(high[1] - low[1])


def _no_hits() -> Hits:
    """A view past which the object lies."""
    empty = np.empty((0, 3))
    return Hits(np.empty((0, 2), np.int32), np.empty(0, np.int32), empty, empty, np.empty(0))


def _scene(mi: Any, mesh: Any, *, light: bool) -> Any:
    """Scene of a mesh, with the laser as a point light or without."""
    scene: dict[str, Any] = {"type": "scene", "embree_use_robust_intersections": True, "object": mesh}
    if light:
        scene["laser"] = {"type": "point", "position": [0.0, 0.0, 1000.0], "intensity": 1.0}
    return mi.load_dict(scene)


def _sensor(
    mi: Any, config: ScannerConfig, pose: NDArray[np.float64], window: tuple[int, int, int, int]
) -> Any:
    """Pinhole camera with rays through pixel centres, rendering a window of the image."""
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
            "sampler": {"type": "stratified", "jitter": False, "sample_count": 1},
        }
    )
