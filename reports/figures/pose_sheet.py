"""All poses of collections side by side, each named: what there is, at a glance."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from numpy.typing import NDArray

from datasets_gen import Collection, Shape
from datasets_gen.meshes.geometry import unit_vectors, vertex_normals
from reports.figures.cloud_drawing import place_cloud
from reports.figures.point_renderer import best_azimuth, fitted_cameras, look_from
from reports.figures.style import HEADROOM, blank, new_figure, styled

CLAY = "#c7a88f"
SAMPLES = 40_000
MOST_STEPS = 200
"""Points along an edge: a box of twelve faces is drawn by them, too."""


@styled
def pose_sheet(
    collections: Sequence[Collection], columns: int = 6, up: int = 1, height: int = 300, inches: float = 1.5
) -> Figure:
    """Every pose of every collection, those of one at one scale and from one side.

    Parameters
    ----------
    collections
    columns
        Pictures in a row; the poses of a collection begin a new one.
    up
        Axis that points upwards.
    height
        Pixels of the tallest pose of each collection.
    inches
        Height of a picture on paper.
    """
    rows = [
        (body, body.shapes[start : start + columns])
        for body in collections
        for start in range(0, len(body), columns)
    ]
    figure, grid = new_figure(
        len(rows), columns, 1.12 * inches * columns, (inches + 0.3) * len(rows), HEADROOM
    )
    for body in collections:
        clouds = {shape.pose: surface_points(shape) for shape in body.shapes}
        azimuth = best_azimuth(body.reference.vertices, up)
        rotation = look_from(azimuth - 180 if azimuth > 90 else azimuth, up=up)  # faces rather than backs
        cameras = fitted_cameras([points for points, _ in clouds.values()], rotation, height)
        width = max(camera.width for camera in cameras)
        framed = dict(zip(clouds, (replace(camera, width=width) for camera in cameras), strict=True))
        for axes, (owner, row) in zip(grid, rows, strict=True):
            if owner is not body:
                continue
            for each in axes:
                blank(each)
            for each, shape in zip(axes, row, strict=False):
                points, normals = clouds[shape.pose]
                colors = np.tile(to_rgb(CLAY), (len(points), 1))
                place_cloud(each, points, normals, colors, framed[shape.pose])
                first = shape is body.shapes[0]
                each.set_title(f"{body.subject}\n{shape.pose}" if first else shape.pose)
    return figure


def surface_points(shape: Shape, count: int = SAMPLES) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Some `count` points or more, as near each other on large faces as on small; smooth normals; (n, 3)."""
    corners = shape.vertices[shape.faces]
    longest = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2).max(axis=1)
    spacing = np.sqrt(2 * shape.area / count)  # two triangles of a lattice have a square's area
    steps = np.clip(np.ceil(longest / spacing), 1, MOST_STEPS).astype(np.int64)
    found = [_lattice(int(each)) for each in range(1, steps.max() + 1)]
    alike = [np.flatnonzero(steps == k + 1) for k in range(len(found))]
    faces = np.concatenate([np.repeat(ids, len(each)) for ids, each in zip(alike, found, strict=True)])
    weights = np.concatenate([np.tile(each, (len(ids), 1)) for ids, each in zip(alike, found, strict=True)])
    normals = vertex_normals(shape.vertices, shape.faces)[shape.faces[faces]]
    return shape.at(faces, weights), unit_vectors(np.einsum("nc,ncd->nd", weights, normals))


def _lattice(steps: int) -> NDArray[np.float64]:
    """Barycentrics (steps^2, 3) of the centres of the equal triangles into which so many steps cut one."""
    i, j = (each.ravel() for each in np.meshgrid(np.arange(steps), np.arange(steps), indexing="ij"))
    upright = i + j < steps
    places = np.stack([i, j], axis=1) + 1 / 3
    places[~upright] = steps - places[~upright]  # the triangles between the others
    return np.column_stack([places, steps - places.sum(axis=1)]) / steps
