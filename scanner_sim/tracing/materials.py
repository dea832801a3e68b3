"""Surfaces as Mitsuba BSDFs."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

import numpy as np

from datasets_gen.meshes.colours import Texture
from datasets_gen.records import InputError
from datasets_gen.shape import Shape
from scanner_sim.scanner_config import ScannerConfig
from scanner_sim.tracing import albedo

Attributes = Mapping[str, Any]
"""Values per vertex, ``vertex_*`` (v,) or (v, k), or face, ``face_*`` (f,) or (f, k); ``vertex_uv`` (v, 2);
``texture``, a `Texture`."""


def _gray(value: float) -> dict[str, Any]:
    return {"type": "rgb", "value": value}


MATERIALS: Mapping[str, Mapping[str, Any]] = MappingProxyType(
    {
        "white": {"type": "diffuse", "reflectance": _gray(1.0)},
        "gray": {"type": "diffuse", "reflectance": _gray(0.5)},
        "black": {"type": "diffuse", "reflectance": _gray(0.05)},
        "plastic": {"type": "roughplastic", "diffuse_reflectance": _gray(0.6), "alpha": 0.15},
        "metal": {"type": "roughconductor", "material": "Al", "alpha": 0.3},
        "coated": {"type": "plastic", "diffuse_reflectance": _gray(0.8)},
        "vertex_albedo": {
            "type": "diffuse",
            "reflectance": {"type": "mesh_attribute", "name": "vertex_albedo"},
        },
        "face_albedo": {"type": "diffuse", "reflectance": {"type": "mesh_attribute", "name": "face_albedo"}},
        albedo.COLOURS: {"type": "diffuse", "reflectance": _gray(1.0)},
    }
)
"""Materials by name: three diffuse ones, rough plastic, rough aluminium, a diffuse base under a smooth
dielectric coat, diffuse ones whose albedo is an attribute given per vertex or per face, and a diffuse one
with the colours of the mesh: white here, `albedo` is multiplied with what returns."""


def bsdf(mi: Any, config: ScannerConfig, attributes: Attributes) -> Any:
    """The surface of a configuration, as a Mitsuba object.

    Raises
    ------
    InputError
        If the material is unknown or malformed, uses an attribute that is not given, or reflects like a
        mirror, so that nothing returns.
    """
    material = config.material
    if material == albedo.COLOURS and config.bounces > 1:
        raise InputError(
            f"material {material!r} needs bounces = 1, got {config.bounces}; 'vertex_albedo' bounces"
        )
    if isinstance(material, str):
        if material not in MATERIALS:
            raise InputError(
                f"material {material!r} is unknown; known are {', '.join(MATERIALS)}, or give a table"
            )
        material = MATERIALS[material]
    for name in _needed(material):
        if name not in attributes:
            raise InputError(f"material {config.material!r} needs the attribute {name!r}; pass it to scan")
    try:
        surface = mi.load_dict(_plain(material))
    except Exception as error:  # Mitsuba raises RuntimeError, TypeError and others
        reason = str(error).strip().splitlines()[-1] if str(error).strip() else type(error).__name__
        raise InputError(f"material {_plain(material)!r} is no Mitsuba BSDF: {reason}") from error
    if not isinstance(surface, mi.BSDF):
        raise InputError(f"material {_plain(material)!r} is no Mitsuba BSDF; give one, as type = 'diffuse'")
    if not mi.has_flag(surface.flags(), mi.BSDFFlags.Smooth):
        raise InputError(
            f"material {config.material!r} has no diffuse or glossy part: it mirrors the laser away, so no "
            "light returns to the camera; use a rough variant"
        )
    return surface


def _needed(material: Mapping[str, Any]) -> list[str]:
    """Names of the attributes that a material reads."""
    found = [str(material.get("name"))] if material.get("type") == "mesh_attribute" else []
    return found + [
        name for value in material.values() if isinstance(value, Mapping) for name in _needed(value)
    ]


def _plain(material: Mapping[str, Any]) -> dict[str, Any]:
    """Nested plain dicts, as Mitsuba wants them."""
    return {key: _plain(value) if isinstance(value, Mapping) else value for key, value in material.items()}


def check_attributes(shape: Shape, attributes: Attributes) -> None:
    """Raise InputError for attributes that do not fit the mesh."""
    sizes = {"vertex": len(shape.vertices), "face": len(shape.faces)}
    for name, values in attributes.items():
        if name == "texture":
            if not isinstance(values, Texture):
                raise InputError(f"attribute 'texture' must be a Texture, got {type(values).__name__!r}")
            continue
        kind, _, rest = name.partition("_")
        if kind not in sizes or not rest:
            raise InputError(f"attribute {name!r} must be named 'vertex_...', 'face_...' or 'texture'")
        array = np.asarray(values)
        if array.ndim not in (1, 2) or len(array) != sizes[kind] or not np.isfinite(array).all():
            raise InputError(
                f"attribute {name!r} must hold a finite value for each of {sizes[kind]} {kind} elements, "
                f"got shape {array.shape}"
            )
        if name == "vertex_uv" and array.shape != (sizes["vertex"], 2):
            raise InputError(f"attribute 'vertex_uv' must have two columns, got shape {array.shape}")
