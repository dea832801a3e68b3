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
    """Some `count` points or more on a lattice in every face, and smooth normals there, both (n, 3)."""
    steps = max(int(np.ceil(np.sqrt(count / len(shape.faces)))), 1)
    i, j = (each.ravel() for each in np.meshgrid(np.arange(steps), np.arange(steps), indexing="ij"))
    upright = i + j < steps
    places = np.stack([i, j], axis=1) + 1 / 3
    places[~upright] = steps - places[~upright]  # the triangles between the others
    lattice = np.column_stack([places, steps - places.sum(axis=1)]) / steps
    faces = np.repeat(np.arange(len(shape.faces)), len(lattice))
    weights = np.tile(lattice, (len(shape.faces), 1))
    corners = vertex_normals(shape.vertices, shape.faces)[shape.faces[faces]]
    return shape.at(faces, weights), unit_vectors(np.einsum("nc,ncd->nd", weights, corners))
