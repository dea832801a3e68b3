"""Clouds of surveying: LAS, and LAZ, which is the same packed."""

import struct
from importlib.util import find_spec
from io import BytesIO

import numpy as np

from datasets_gen.clouds.point_cloud import PointCloud
from datasets_gen.extras import pip_install
from datasets_gen.records import InputError

NORMALS = ("nx", "ny", "nz"), ("normalx", "normaly", "normalz"), ("NormalX", "NormalY", "NormalZ")
"""Names of extra dimensions that hold normals."""
SHORTEST = 227
"""Bytes of the header of LAS 1.2."""
LONG_HEADER = 375
"""Bytes of the header from LAS 1.4 on."""
NEWEST = 5
"""Minor version; laspy goes by it alone and takes 0.4 for 1.4, whose counts then are others."""
RECORD, LONG_RECORD = 54, 60
"""Bytes of the head of a variable record, before the points and after them."""
MOST_PACKED = 1000
"""Points per byte of a packed file; coordinates that are all the same take a hundredth of a byte each."""
LARGEST_CHUNK = 50_000_000
"""Points that are unpacked at once; usual are 50,000."""
VARIABLE = 2**32 - 1
"""Size of chunks that differ."""


def read_las(content: bytes, where: str) -> PointCloud:
    """Read a LAS or LAZ file: coordinates in double precision, with scale and offset applied.

    Raises
    ------
    InputError
        If laspy is not installed.
    ValueError
        If the file is damaged; laspy raises anything else on a damaged file.
    """
    if find_spec("laspy") is None:
        raise InputError(f"{where} needs laspy, which is not installed; {pip_install('las')}")
    count = _checked_count(content)
    import laspy

    try:
        found = laspy.read(BytesIO(content))
    except BaseException as error:
        if type(error).__name__ != "PanicException":  # of lazrs, which no Exception is
            raise
        raise ValueError("the packed points are damaged") from error
    if len(found.points) != count:
        raise ValueError(f"{len(found.points)} points where {count} should be")
    points = np.column_stack([np.asarray(axis, dtype=np.float64) for axis in (found.x, found.y, found.z)])
    extra = set(found.point_format.extra_dimension_names)
    names = next((each for each in NORMALS if set(each) <= extra), None)
    normals = None if names is None else np.column_stack([np.asarray(found[n], np.float64) for n in names])
    return PointCloud(points, normals)


def _checked_count(content: bytes) -> int:
    """Number of points, by the header, whose counts have to fit into the file.

    laspy and lazrs trust them: a damaged one takes all memory, or ends the process.
    """
    if len(content) < SHORTEST or content[:4] != b"LASF":
        raise ValueError("no header of a LAS file")
    major, minor = content[24], content[25]
    if major != 1 or minor > NEWEST:
        raise ValueError(f"version {major}.{minor} of LAS, where 1.0 to 1.{NEWEST} are read")
    start, records, kind, length, count = struct.unpack_from("<IIBHI", content, 96)
    if minor >= 4:
        if len(content) < LONG_HEADER:
            raise ValueError(f"{len(content)} bytes, where the header alone takes {LONG_HEADER}")
        after, long_records, count = struct.unpack_from("<QIQ", content, 235)
        if long_records and after + LONG_RECORD * long_records > len(content):
            raise ValueError(f"{long_records} records at byte {after}, beyond the end of the file")
    if start > len(content) or records * RECORD > start:
        raise ValueError(f"points at byte {start} after {records} records, which do not fit")
    room = len(content) - start
    if not kind & 0xC0:
        if length < 20 or count * length > room:
            raise ValueError(f"{room} bytes of points where {count} of {length} bytes should be")
        return int(count)
    if count > MOST_PACKED * max(room, 1) or length < 20:
        raise ValueError(f"{count} points in {room} bytes")
    _check_chunks(content, start, records)
    return int(count)


def _check_chunks(content: bytes, start: int, records: int) -> None:
    """Sizes that a packed file names: of its chunks, and of the table of them."""
    place = struct.unpack_from("<H", content, 94)[0]
    for _ in range(records):
        number, size = struct.unpack_from("<HH", content, place + 18)
        if content[place + 2 : place + 18].rstrip(b"\0") == b"laszip encoded" and number == 22204:
            chunk, items = (
                struct.unpack_from("<I", content, place + RECORD + 12)[0],
                content[place + RECORD + 32],
            )
            if (chunk > LARGEST_CHUNK and chunk != VARIABLE) or not items:
                raise ValueError(f"chunks of {chunk} points of {items} items")
        place += RECORD + size
    table = struct.unpack_from("<q", content, start)[0]
    table = struct.unpack_from("<q", content, len(content) - 8)[0] if table == -1 else table
    if not start + 8 <= table <= len(content) - 8:
        raise ValueError(f"a table of chunks at byte {table}, outside the points")
    chunks = struct.unpack_from("<I", content, table + 4)[0]
    if chunks > len(content):
        raise ValueError(f"{chunks} chunks in {len(content)} bytes")
