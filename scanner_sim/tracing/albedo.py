"""Colours of a mesh as albedo at the laser's wavelength.

A colour is three numbers, not a spectrum. It is assumed that the reflectance is the colour's linear red,
green and blue at 640, 532 and 450 nm, usual lines of lasers of these colours, and linear in between: a red
laser of 650 nm sees the red channel. Near infrared, too, sees the red channel, for want of better.
"""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.meshes.colours import Texture
from datasets_gen.records import InputError
from datasets_gen.shape import Shape

COLOURS = "colours"
"""The material whose albedo is the mesh's own."""
LINES = (450.0, 532.0, 640.0)
"""Wavelengths at which reflectance is blue, green and red, nm."""
NAMES = ("texture", "vertex_colour", "face_colour")
"""Attributes that give colours, in the order in which they are looked for."""

AlbedoAt = Callable[[NDArray[np.integer], NDArray[np.float64]], NDArray[np.float64]]
"""Albedo (n,) at face numbers (n,) and barycentric coordinates (n, 3)."""


def channel_weights(wavelength: float) -> NDArray[np.float64]:
    """Weights (3,) of linear red, green and blue in the reflectance at a wavelength in nm; they sum to 1."""
    return np.array([np.interp(wavelength, LINES, peak) for peak in ((0, 0, 1), (0, 1, 0), (1, 0, 0))])


def linear(values: NDArray[np.floating]) -> NDArray[np.float64]:
    """SRGB in 0..1 to linear light [IEC 61966-2-1]."""
    values = np.asarray(values, np.float64)
    return np.where(values <= 0.04045, values / 12.92, ((values + 0.055) / 1.055) ** 2.4)


def of_colours(colours: NDArray[Any], wavelength: float, name: str = "colours") -> NDArray[np.float64]:
    """Albedo (...) of sRGB colours (..., 3 or 4): whole numbers up to their type's largest, or 0..1.

    Raises
    ------
    InputError
        If there are not three or four channels, or fractions outside 0..1.
    """
    values = np.asarray(colours)
    if values.ndim < 2 or values.shape[-1] not in (3, 4):
        raise InputError(f"{name!r} must hold red, green and blue in its last axis, got shape {values.shape}")
    values = values[..., :3]
    if values.dtype.kind in "iu":
        largest = 65535 if values.dtype == np.uint16 else 255
        values = values / largest
    if values.size and not (values.min() >= 0 and values.max() <= 1):
        low, high = values.min(), values.max()
        raise InputError(
            f"{name!r} must lie in 0..1, or in 0..255 as whole numbers, got {low:.4g}..{high:.4g}"
        )
    return linear(values) @ channel_weights(wavelength)


def lookup(shape: Shape, attributes: Mapping[str, Any], wavelength: float) -> AlbedoAt:
    """How to look up the albedo of points on a shape.

    Parameters
    ----------
    shape
    attributes
        With ``texture`` (`Texture`), ``vertex_colour`` (v, 3 or 4) or ``face_colour`` (f, 3 or 4); the first
        that is there is taken. Between vertices and texels, albedo is linear.
    wavelength
        Of the laser, nm.

    Raises
    ------
    InputError
        If there is none of them, or it does not fit.
    """
    name = next((name for name in NAMES if name in attributes), None)
    if name is None:
        raise InputError(
            f"material {COLOURS!r} needs the colours of the mesh: give a file or mesh that has some, or "
            f"one of the attributes {', '.join(NAMES)}"
        )
    if name == "texture":
        return _of_texture(shape, attributes[name], wavelength)
    values = of_colours(attributes[name], wavelength, name)
    if name == "face_colour":
        return lambda face_ids, barycentrics: values[face_ids]
    corners = values[shape.faces]
    return lambda face_ids, barycentrics: np.einsum("nc,nc->n", barycentrics, corners[face_ids])


def _of_texture(shape: Shape, texture: Texture, wavelength: float) -> AlbedoAt:
    """Look up a texture."""
    images = [of_colours(image, wavelength, "texture") for image in texture.images]
    uv = texture.uv_in_order_of(shape.faces)

    def albedo(face_ids: NDArray[np.integer], barycentrics: NDArray[np.float64]) -> NDArray[np.float64]:
        place = np.einsum("nc,nck->nk", barycentrics, uv[face_ids])
        which = texture.image_of_face[face_ids]
        out = np.empty(len(face_ids))
        for number, image in enumerate(images):
            here = which == number
            out[here] = bilinear(image, place[here])
        return out

    return albedo


def bilinear(image: NDArray[np.float64], uv: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values (n,) of an image (h, w) at texture coordinates (n, 2), linear between pixel centres.

    u runs from left to right, v from bottom to top; the image repeats.
    """
    height, width = image.shape
    x, y = uv[:, 0] * width - 0.5, (1 - uv[:, 1]) * height - 0.5
    column, row = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    right, below = x - column, y - row
    out = np.zeros(len(uv))
    for i, across in ((0, 1 - right), (1, right)):
        for j, down in ((0, 1 - below), (1, below)):
            out += across * down * image[(row + j) % height, (column + i) % width]
    return out
