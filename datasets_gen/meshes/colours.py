"""Colours of mesh files: per vertex, per face, or a texture; for scans with ``material = "colours"``.

Colours are kept as they are stored, as sRGB in 0..255 or 0..1. `files` reads the geometry; what is read here
follows the same order of vertices and faces.
"""

import os
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.paths import inside
from datasets_gen.records import InputError

Colours = dict[str, Any]
"""One of ``vertex_colour`` (v, 3 or 4), ``face_colour`` (f, 3 or 4) and ``texture`` (`Texture`)."""

_CHANNELS = ("red", "green", "blue")
_COORDINATES = (("texture_u", "texture_v"), ("u", "v"), ("s", "t"))


@dataclass(frozen=True)
class Texture:
    """Images on a mesh.

    Attributes
    ----------
    images : tuple of (h, w, 3 or 4) arrays
        sRGB, first row on top.
    image_of_face : (f,) int64
        Into `images`.
    uv : (f, 3, 2) float64
        Of the corners: 0..1 from left to right and from bottom to top; images repeat beyond.
    faces : (f, 3) int64
        Vertices of those corners, so that another order of the corners can be followed.
    """

    images: tuple[NDArray[Any], ...]
    image_of_face: NDArray[np.int64]
    uv: NDArray[np.float64]
    faces: NDArray[np.int64]

    @classmethod
    def of_vertices(
        cls, image: NDArray[Any], uv: NDArray[np.floating], faces: NDArray[np.integer]
    ) -> "Texture":
        """One image with texture coordinates (v, 2) of the vertices."""
        corners = np.asarray(uv, np.float64)[faces]
        return cls((np.asarray(image),), np.zeros(len(faces), np.int64), corners, faces.astype(np.int64))

    def uv_in_order_of(self, faces: NDArray[np.integer]) -> NDArray[np.float64]:
        """Texture coordinates (f, 3, 2) of the corners of the same faces, each wound either way.

        Raises
        ------
        InputError
            If they are not the same faces.
        """
        if len(faces) != len(self.faces):
            raise InputError(
                f"the texture is for {len(self.faces)} faces, but the mesh has {len(faces)}; "
                "give the mesh that it was made for, without repair"
            )
        mine, theirs = np.argsort(self.faces, axis=1), np.argsort(faces, axis=1)
        out = np.empty_like(self.uv)
        rows = np.arange(len(faces))[:, None]
        out[rows, theirs] = self.uv[rows, mine]
        return out


def colours_of(mesh: Any) -> Colours:
    """Colours of a mesh file or of a ``trimesh.Trimesh``; none of anything else.

    Raises
    ------
    InputError
        As `read_colours`.
    """
    if isinstance(mesh, str | os.PathLike):
        return {} if Path(mesh).suffix.lower() == ".npz" else read_colours(mesh)
    return _of_trimesh(mesh) if hasattr(mesh, "visual") else {}


def read_colours(path: str | os.PathLike[str]) -> Colours:
    """Colours of a mesh file: its texture, else its vertex colours, else its face colours.

    PLY: ``red green blue`` of vertices or faces; ``s t`` or ``texcoord`` with ``comment TextureFile``. OBJ:
    ``map_Kd`` and ``Kd`` of its materials, or vertices ``v x y z r g b``. OFF: vertex colours (COFF).

    Parameters
    ----------
    path
        A file that `files.read_mesh` reads.

    Returns
    -------
    Colours

    Raises
    ------
    InputError
        If the file has no colours, or a texture or material file that it names is missing.
    """
    file = Path(path)
    try:
        content = file.read_bytes()
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be read: {error.strerror}; give a mesh file") from error
    readers = {".ply": _of_ply, ".obj": _of_obj, ".off": _of_off}
    try:
        found = readers.get(file.suffix.lower(), _none)(content, file)
    except InputError:
        raise
    except Exception as error:  # parsers raise anything on a broken file
        raise InputError(f"the colours of {str(path)!r} cannot be read ({error}); export it again") from error
    if not found:
        raise InputError(
            f"{str(path)!r} has no colours (of vertices, faces or a texture); choose another material"
        )
    return found


def _none(content: bytes, file: Path) -> Colours:
    """Of formats whose colours are not read."""
    return {}


def _loaded(content: bytes, kind: str, **options: Any) -> Any:
    import trimesh  # in the functions that need it: a start without it takes half as long

    return trimesh.load(BytesIO(content), file_type=kind, process=False, **options)


def _image(name: str, mesh: Path) -> NDArray[np.uint8]:
    """Image file named by a mesh file, (h, w, 3)."""
    from PIL import Image, UnidentifiedImageError

    place = inside(mesh.parent, name.replace("\\", "/"), f"texture of {mesh.name!r},")
    try:
        with Image.open(place) as image:
            return np.asarray(image.convert("RGB"))
    except FileNotFoundError as error:
        raise InputError(
            f"the texture {name!r} of {str(mesh)!r} is missing; put it at {str(place)!r} or choose another "
            "material"
        ) from error
    except (OSError, UnidentifiedImageError) as error:
        raise InputError(f"the texture {str(place)!r} is no image that can be read ({error})") from error


def _of_trimesh(mesh: Any) -> Colours:
    visual = mesh.visual
    if visual.kind in ("vertex", "face"):
        return {f"{visual.kind}_colour": np.array(getattr(visual, f"{visual.kind}_colors"))}
    material = getattr(visual, "material", None)
    image = getattr(material, "image", None) or getattr(material, "baseColorTexture", None)
    if image is None or getattr(visual, "uv", None) is None:
        return {}
    pixels = np.asarray(image.convert("RGB"))
    return {"texture": Texture.of_vertices(pixels, np.asarray(visual.uv), np.asarray(mesh.faces))}


def _of_ply(content: bytes, file: Path) -> Colours:
    mesh = _loaded(content, "ply", fix_texture=False, skip_materials=True)
    elements = mesh.metadata["_ply_raw"]
    header = content[: content.index(b"end_header")].decode("utf-8", "replace").splitlines()
    names = [line.split(None, 2)[2] for line in header if line.lower().startswith("comment texturefile ")]
    uv = _ply_coordinates(elements, np.asarray(mesh.faces))
    if names and uv is not None:
        faces = np.asarray(mesh.faces, np.int64)
        return {"texture": Texture((_image(names[0], file),), np.zeros(len(faces), np.int64), uv, faces)}
    for element in ("vertex", "face"):
        data = elements[element]["data"]
        if all(channel in elements[element]["properties"] for channel in _CHANNELS):
            colour = np.stack([np.ravel(data[channel]) for channel in _CHANNELS], axis=1)
            if element == "face" and len(colour) != len(mesh.faces):
                raise InputError(f"{str(file)!r} has colours of polygons; cut them into triangles")
            return {f"{element}_colour": colour}
    return {}


def _ply_coordinates(elements: Any, faces: NDArray[np.integer]) -> NDArray[np.float64] | None:
    """Texture coordinates of the corners of a PLY file, (f, 3, 2)."""
    if "texcoord" in elements["face"]["properties"]:
        data = elements["face"]["data"]["texcoord"]
        listed = np.asarray(data["f1"] if getattr(data.dtype, "names", None) else data, np.float64)
        if listed.shape == (len(faces), 6):
            return listed.reshape(-1, 3, 2)
    for names in _COORDINATES:
        if all(name in elements["vertex"]["properties"] for name in names):
            data = elements["vertex"]["data"]
            return np.stack([np.ravel(data[name]) for name in names], axis=1).astype(np.float64)[faces]
    return None


def _of_off(content: bytes, file: Path) -> Colours:
    lines = [line.split(b"#")[0].split() for line in content.splitlines()]
    lines = [line for line in lines if line]
    if lines[0][0].upper() != b"COFF":
        return {}
    counts, rows = (lines[0][1:], lines[1:]) if len(lines[0]) > 1 else (lines[1], lines[2:])
    values = [row[3:6] for row in rows[: int(counts[0])]]
    whole = not any(b"." in value for row in values for value in row)
    colour = np.array(values, np.float64)
    return {"vertex_colour": colour.astype(np.uint8) if whole else colour}


def _of_obj(content: bytes, file: Path) -> Colours:
    lines = content.replace(b"\\\n", b"").splitlines()
    used, current, polygons = {b"": 0}, 0, []  # materials by name; (material, corners) of every polygon
    for line in lines:
        words = line.split(None, 1)
        if words[:1] == [b"usemtl"]:
            current = used.setdefault(words[1].strip() if len(words) > 1 else b"", len(used))
        elif words[:1] == [b"f"]:
            polygons.append((current, [word.split(b"/") for word in words[1].split()]))
    points = [line for line in lines if line.startswith((b"v ", b"v\t"))]
    coordinates = [line for line in lines if line.startswith((b"vt ", b"vt\t"))]
    libraries = [line.split(None, 1)[1].strip() for line in lines if line.startswith(b"mtllib ")]
    if libraries and len(used) > 1:
        images = _material_images(libraries, list(used), file)
        shape = _with_indices(points, [[c[0] for c in corners] for _, corners in polygons])
        numbers = _with_indices([b"v 0 0 0"] * len(used), [[b"%d" % (m + 1)] * len(c) for m, c in polygons])
        uv = np.zeros((len(shape.faces), 3, 2))
        if all(len(corner) > 1 and corner[1] for _, corners in polygons for corner in corners):
            places = [b"v " + b" ".join([*line.split()[1:3], b"0", b"0"][:3]) for line in coordinates]
            textured = _with_indices(places, [[c[1] for c in corners] for _, corners in polygons])
            uv = np.asarray(textured.vertices)[textured.faces][..., :2]
        elif any(image.shape[:2] != (1, 1) for image in images):
            raise InputError(f"{str(file)!r} has a texture but faces without texture coordinates (vt)")
        which = np.asarray(numbers.faces)[:, 0].astype(np.int64)
        return {"texture": Texture(images, which, uv, np.asarray(shape.faces, np.int64))}
    values = [line.split()[4:7] for line in points]
    if values and all(len(value) == 3 for value in values):
        return {"vertex_colour": np.array(values, np.float64)}
    return {}


def _with_indices(vertices: list[bytes], corners: list[list[bytes]]) -> Any:
    """What the reader of geometry makes of other vertices and indices: it cuts polygons in the same way."""
    faces = [b"f " + b" ".join(corner) for corner in corners]
    return _loaded(b"\n".join([*vertices, *faces]), "obj", maintain_order=True)


def _material_images(libraries: list[bytes], used: list[bytes], mesh: Path) -> tuple[NDArray[np.uint8], ...]:
    """Image of each material in use: its ``map_Kd``, or one pixel of its ``Kd``; white where it has none."""
    named: dict[bytes, NDArray[np.uint8]] = {}
    defined: set[bytes] = set()
    for library in libraries:
        named_as = library.decode("utf-8", "replace")
        place = inside(mesh.parent, named_as, f"material file of {mesh.name!r},")
        if not place.is_file():
            raise InputError(
                f"the material file {place.name!r} of {str(mesh)!r} is missing; put it at {str(place)!r} or "
                "choose another material"
            )
        name, mapped = b"", False
        for line in place.read_bytes().splitlines():
            key, _, rest = line.strip().partition(b" ")
            if key == b"newmtl":
                name, mapped = rest.strip(), False
                defined.add(name)
            elif key.lower() == b"map_kd" and name in used:
                named[name], mapped = _image(rest.decode("utf-8", "replace").strip(), mesh), True
            elif key == b"Kd" and not mapped:
                colour = np.array(rest.split()[:3], np.float64)
                named[name] = np.round(255 * np.clip(colour, 0, 1)).astype(np.uint8)[None, None]
    unknown = [name.decode("utf-8", "replace") for name in used if name and libraries and name not in defined]
    if unknown:
        raise InputError(
            f"{str(mesh)!r} uses the material {unknown[0]!r}, which its material files do not define; "
            "define it or choose another material"
        )
    white = np.full((1, 1, 3), 255, np.uint8)
    return tuple(named.get(name, white) for name in used)
