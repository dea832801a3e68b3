"""glTF 2.0 files, ``.glb`` and ``.gltf``: the JSON, the buffers and the arrays in them.

Own code, as no library keeps what a character needs: trimesh drops skins and animations, and pygltflib leaves
accessors undecoded. Read are data URIs and files beside the ``.gltf``, strides, normalised integers and
sparse accessors. Compressed geometry is refused by the name of its extension.

References
----------
Khronos Group, "glTF 2.0 Specification", version 2.0.1, 2021.
"""

import base64
import binascii
import struct
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from urllib.parse import unquote

import numpy as np
from numpy.typing import NDArray

from datasets_gen.parsing import parsed_json
from datasets_gen.paths import inside
from datasets_gen.records import InputError

GLTF_SUFFIXES = (".glb", ".gltf")

_COMPONENTS = {
    5120: np.int8,
    5121: np.uint8,
    5122: np.int16,
    5123: np.uint16,
    5125: np.uint32,
    5126: np.float32,
}
_WIDTHS = {"SCALAR": 1, "VEC2": 2, "VEC3": 3, "VEC4": 4, "MAT4": 16}
_LOOKS = (
    "KHR_materials_",
    "KHR_texture_",
    "EXT_texture_",
    "MSFT_texture_",
    "KHR_lights_",
    "EXT_lights_",
    "KHR_xmp",
)
_READ = ("KHR_mesh_quantization",)
_LISTS = ("accessors", "animations", "buffers", "bufferViews", "meshes", "nodes", "scenes", "skins")
_JSON, _BIN = 0x4E4F534A, 0x004E4942
_MOST_VALUES = 10**8
"""Of an accessor without data, which are zeros."""


@dataclass(frozen=True)
class GltfFile:
    """A parsed file.

    Attributes
    ----------
    path : Path
    content : dict
        The JSON.
    blob : bytes or None
        The binary chunk of a ``.glb``.
    """

    path: Path
    content: dict[str, Any]
    blob: bytes | None = None

    @classmethod
    def read(cls, path: Path) -> "GltfFile":
        """Read the JSON of a file; buffers are read when their arrays are asked for.

        Raises
        ------
        InputError
            If it is no glTF 2.0, or needs an extension that is not read here.
        """
        try:
            data = path.read_bytes()
        except OSError as error:
            raise InputError(f"{str(path)!r} cannot be read: {error.strerror}; give a glTF file") from error
        text, blob = _chunks(path, data) if data[:4] == b"glTF" else (data, None)
        content = parsed_json(text.rstrip(b"\0 "), repr(str(path)))
        version = _version(content)
        if not str(version).startswith("2."):
            raise InputError(f"{str(path)!r} is no glTF 2 (version {version!r}); export it again as glTF 2.0")
        wrong = next((kind for kind in _LISTS if not _are_tables(content.get(kind, []))), None)
        if wrong is not None or not isinstance(content.get("extensionsRequired", []), list):
            raise InputError(
                f"{str(path)!r}: {wrong or 'extensionsRequired'} is no list of glTF; export it again"
            )
        for name in content.get("extensionsRequired", ()):
            if not str(name).startswith(_LOOKS) and name not in _READ:
                raise InputError(
                    f"{str(path)!r} needs the glTF extension {name}, which is not read here; export it "
                    "without (no compression)"
                )
        return cls(path, content, blob)

    def part(self, kind: str, index: Any) -> dict[str, Any]:
        """Entry of a list of the JSON, such as the third of ``"nodes"``.

        Raises
        ------
        InputError
            If there is none.
        """
        entries = self.content.get(kind, [])
        if not isinstance(index, int) or not 0 <= index < len(entries):
            raise InputError(
                f"{str(self.path)!r} names {index!r} of {len(entries)} {kind}, from 0; export it again"
            )
        entry: dict[str, Any] = entries[index]
        return entry

    def array(self, index: Any, width: int) -> NDArray[Any]:
        """Values of an accessor.

        Parameters
        ----------
        index
        width
            Numbers of each value: 3 for vectors, 16 for matrices.

        Returns
        -------
        (n, width)
            Integers as stored, or float64; normalised integers in [0, 1] or [-1, 1].

        Raises
        ------
        InputError
            If it is damaged or of another type, or its buffer is not there.
        """
        with self.checked(f"accessor {index}"):
            accessor = self.part("accessors", index)
            found, kind = _WIDTHS.get(accessor["type"]), np.dtype(_COMPONENTS[accessor["componentType"]])
            if found != width:
                raise ValueError(f"it holds {accessor['type']}, not {width} numbers each")
            count = int(accessor["count"])
            if not 0 <= count <= _MOST_VALUES:
                raise ValueError(f"it counts {count} values")
            if "bufferView" in accessor:
                values = self._view(accessor["bufferView"], accessor.get("byteOffset", 0), kind, count, width)
            else:
                values = np.zeros((count, width), dtype=kind)
            if "sparse" in accessor:
                values = self._with_sparse(values, accessor["sparse"])
            return _as_numbers(values, bool(accessor.get("normalized", False)))

    def _with_sparse(self, values: NDArray[Any], sparse: dict[str, Any]) -> NDArray[Any]:
        """The values with those that a sparse accessor has instead."""
        count, places, others = int(sparse["count"]), sparse["indices"], sparse["values"]
        kind = np.dtype(_COMPONENTS[places["componentType"]])
        where = self._view(places["bufferView"], places.get("byteOffset", 0), kind, count, 1).ravel()
        if count and where.max() >= len(values):
            raise ValueError(f"a sparse value is at {where.max()} of {len(values)}")
        given = self._view(
            others["bufferView"], others.get("byteOffset", 0), values.dtype, count, values.shape[1]
        )
        values = values.copy()
        values[where] = given
        return values

    def _view(self, index: Any, offset: int, kind: np.dtype[Any], count: int, width: int) -> NDArray[Any]:
        """A window (count, width) on a buffer."""
        view = self.part("bufferViews", index)
        for name in view.get("extensions", {}):
            raise InputError(
                f"{str(self.path)!r} has a buffer with the glTF extension {name}, which is not read here; "
                "export it without (no compression)"
            )
        stride = view.get("byteStride", kind.itemsize * width)
        start = view.get("byteOffset", 0) + offset
        if min(offset, start, stride) < 0 or (count and offset + (count - 1) * stride + kind.itemsize * width
                                              > view["byteLength"]):  # fmt: skip
            raise ValueError("it reaches beyond its buffer view")
        data = self._buffer(view["buffer"])
        return np.ndarray((count, width), kind.newbyteorder("<"), data, start, (stride, kind.itemsize))

    def _buffer(self, index: Any) -> bytes:
        """Bytes of a buffer: of the binary chunk, a data URI, or a file beside this one."""
        buffer = self.part("buffers", index)
        uri = buffer.get("uri")
        if uri is None:
            if index != 0 or self.blob is None:
                raise ValueError(f"buffer {index} has no data")
            data = self.blob
        elif uri.startswith("data:"):
            data = base64.b64decode(uri.partition(",")[2], validate=True)
        else:
            data = self._beside(unquote(uri))
        if len(data) < buffer["byteLength"]:
            raise ValueError(f"buffer {index} has {len(data)} of {buffer['byteLength']} bytes")
        return data

    def _beside(self, name: str) -> bytes:
        file = inside(self.path.parent, name, "buffer")
        try:
            return file.read_bytes()
        except OSError as error:
            raise InputError(
                f"{str(self.path)!r} keeps its data in {name!r}, which cannot be read ({error.strerror}); "
                "put it beside, or export a .glb"
            ) from error

    def files(self) -> list[Path]:
        """The file itself and those of its buffers that are there."""
        found = [self.path]
        for buffer in self.content.get("buffers", []):
            uri = buffer.get("uri", "data:") if isinstance(buffer, dict) else "data:"
            if isinstance(uri, str) and not uri.startswith("data:"):
                found.append(inside(self.path.parent, unquote(uri), "buffer"))
        return [file for file in found if file.is_file()]

    @contextmanager
    def checked(self, what: str) -> Iterator[None]:
        """Turn the errors of missing and wrong entries into one InputError that says where."""
        try:
            yield
        except InputError:
            raise
        except (
            KeyError,
            TypeError,
            ValueError,
            IndexError,
            AttributeError,
            OverflowError,
            binascii.Error,
        ) as error:
            why = f"{error} is missing" if isinstance(error, KeyError) else " ".join(str(error).split())
            raise InputError(f"{str(self.path)!r}: {what} is damaged ({why}); export it again") from error


def _version(content: Any) -> Any:
    asset = content.get("asset") if isinstance(content, dict) else None
    return asset.get("version") if isinstance(asset, dict) else None


def _are_tables(entries: Any) -> bool:
    return isinstance(entries, list) and all(isinstance(entry, dict) for entry in entries)


def _chunks(path: Path, data: bytes) -> tuple[bytes, bytes | None]:
    """JSON and binary chunk of a ``.glb``."""
    found: dict[int, bytes] = {}
    place = 12
    while place + 8 <= len(data):
        length, kind = struct.unpack_from("<II", data, place)
        if place + 8 + length > len(data):
            break
        found.setdefault(kind, data[place + 8 : place + 8 + length])
        place += 8 + length
    declared = struct.unpack_from("<I", data, 8)[0] if len(data) >= 12 else 12
    if _JSON not in found or declared > len(data):
        raise InputError(
            f"{str(path)!r} is cut short: {len(data)} of {declared} bytes; copy or export it again"
        )
    return found[_JSON], found.get(_BIN)


def _as_numbers(values: NDArray[Any], normalised: bool) -> NDArray[Any]:
    """Stored values as integers or float64."""
    if values.dtype.kind == "f":
        return values.astype(np.float64)
    if not normalised:
        return values.astype(np.int64)
    return np.maximum(values.astype(np.float64) / np.iinfo(values.dtype).max, -1.0)
