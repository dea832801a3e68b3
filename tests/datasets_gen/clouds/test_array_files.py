"""Clouds of NumPy, of the Point Cloud Library and of surveying, by hand or by the formats' own writers."""

import io
import struct

import numpy as np
import pytest

from datasets_gen import InputError
from datasets_gen.clouds import las_clouds
from datasets_gen.clouds.file_formats import read_points
from datasets_gen.extras import pip_install

POINTS = np.array([[0, 0.5, 1.5], [1, 0.25, 0], [2.5, 1, 0.75], [-1, 0, 4]])
UNIT = np.array([[0, 0, -1], [0.6, 0.8, 0], [0, -0.8, 0.6], [0, 1, 0]])


def read(folder, name, content):
    path = folder / name
    path.write_bytes(content)
    return read_points(path)


def npy(array):
    out = io.BytesIO()
    np.save(out, array)
    return out.getvalue()


def npz(**arrays):
    out = io.BytesIO()
    np.savez(out, **arrays)
    return out.getvalue()


@pytest.mark.parametrize("kind", ["f4", ">f8", "f8"])
def test_npy(tmp_path, kind):
    found = read(tmp_path, "a.npy", npy(POINTS.astype(kind)))
    assert np.array_equal(found.points, POINTS)
    assert found.normals is None
    both = read(tmp_path, "a.npy", npy(np.hstack([POINTS, UNIT])))
    assert np.array_equal(both.normals, UNIT)
    coloured = read(tmp_path, "a.npy", npy(np.hstack([POINTS, np.full((4, 3), 17)])))
    assert coloured.normals is None
    assert "colours" in coloured.remarks[0]


def test_npy_with_named_fields(tmp_path):
    kind = np.dtype([("intensity", "u2"), ("X", "f4"), ("Y", "f4"), ("Z", "f4")])
    table = np.zeros(4, kind)
    for axis, name in enumerate("XYZ"):
        table[name] = POINTS[:, axis]
    assert np.array_equal(read(tmp_path, "a.npy", npy(table)).points, POINTS)


def test_npz_of_plain_arrays(tmp_path):
    found = read(tmp_path, "a.npz", npz(points=POINTS, normals=UNIT, colours=POINTS))
    assert np.array_equal(found.points, POINTS)
    assert np.array_equal(found.normals, UNIT)
    mesh = read(tmp_path, "a.npz", npz(vertices=POINTS, faces=np.array([[0, 1, 2], [0, 2, 3]])))
    assert mesh.faces.tolist() == [[0, 1, 2], [0, 2, 3]]


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.npy", npy(np.zeros((4, 2))), "array of shape (4, 2); give (n, 3)"),
        ("a.npy", npy(np.zeros((4, 5))), "has 5 columns"),
        ("a.npy", npy(np.zeros((4, 3), complex)), "complex"),
        ("a.npy", npy(POINTS)[:-8], "cut short"),
        ("a.npz", npz(data=POINTS, other=POINTS), "or vertices or pos; it has data, other"),
        ("a.npz", npz(points=POINTS[:, :2]), "points of shape (4, 2); give (n, 3)"),
        ("a.npz", npz(points=POINTS, normals=UNIT[:2]), "normals of shape (2, 3) and points of shape (4, 3)"),
        ("a.npz", npz(points=POINTS)[:-60], "cut short"),
        ("a.npz", npz(points=POINTS, faces=POINTS), "whole numbers"),
    ],
)  # fmt: skip
def test_arrays_that_are_no_cloud_are_refused(tmp_path, name, content, said):
    with pytest.raises(InputError) as caught:
        read(tmp_path, name, content)
    assert said in str(caught.value)
    assert name in str(caught.value)


FIELDS = "FIELDS x y z rgb normal_x normal_y normal_z _\nSIZE 4 8 4 4 4 4 4 1\nTYPE F F F U F F F U\n"
FIELDS += "COUNT 1 1 1 1 1 1 1 3\nWIDTH 2\nHEIGHT 2\n"
TABLE = [(*p, 7, *n, 1, 2, 3) for p, n in zip(POINTS, UNIT, strict=True)]
ROW = "<fdfIfff3B"


def pcd(storage, body, viewpoint="0 0 0 1 0 0 0"):
    head = f"# .PCD v0.7\nVERSION 0.7\n{FIELDS}VIEWPOINT {viewpoint}\nPOINTS 4\nDATA {storage}\n"
    return head.encode() + body


def packed(literal=False):
    """Columns one after the other, packed: as literal bytes, or with zeros as copies of the byte before."""
    columns = zip(*TABLE, strict=True)
    kinds = ["f", "d", "f", "I", "f", "f", "f"]
    data = b"".join(struct.pack(f"<4{kind}", *column) for kind, column in zip(kinds, columns, strict=False))
    data += bytes([1, 2, 3] * 4)
    out, place = b"", 0
    while place < len(data):
        run = len(data[place:]) - len(data[place:].lstrip(b"\0"))
        if run >= 4 and not literal:  # a zero, then run - 1 copies of it: 3..8 short, 9..264 long
            count = min(run, 265) - 1
            out += b"\0\0" + (bytes([(count - 2) << 5, 0]) if count < 9 else bytes([7 << 5, count - 9, 0]))
            place += count + 1
        else:
            out += b"\0" + data[place : place + 1]
            place += 1
    return struct.pack("<II", len(out), len(data)) + out


BODIES = {
    "ascii": "".join(" ".join(f"{value:g}" for value in row) + "\n" for row in TABLE).encode(),
    "binary": b"".join(struct.pack(ROW, *row) for row in TABLE),
    "binary_compressed": packed(),
}


@pytest.mark.parametrize("storage", BODIES)
def test_pcd_in_each_form(tmp_path, storage):
    found = read(tmp_path, "a.pcd", pcd(storage, BODIES[storage]))
    assert np.array_equal(found.points, POINTS)
    assert np.allclose(found.normals, UNIT, atol=1e-7)
    assert found.remarks == ()
    moved = read(tmp_path, "a.pcd", pcd(storage, BODIES[storage] + b"\n", "1 0 0 1 0 0 0"))
    assert "the pose of the sensor (VIEWPOINT) is not used" in moved.remarks


def test_pcd_copies_that_overlap_themselves(tmp_path):
    assert len(packed()) < len(packed(literal=True)) - 4
    found = read(tmp_path, "a.pcd", pcd("binary_compressed", packed(literal=True)))
    assert np.array_equal(found.points, POINTS)


@pytest.mark.parametrize(
    ("content", "said"),
    [
        (pcd("ascii", BODIES["ascii"][:-11]), "line 15: 5 numbers where 10 should be"),
        (pcd("ascii", b"1 2 3\n"), "1 points where 4 should be"),
        (pcd("binary", BODIES["binary"][:-1]), "139 bytes of points where 140 should be"),
        (pcd("binary_compressed", packed()[:-3]), "packed as"),
        (pcd("binary_compressed", packed()[:12] + b"\xff\xff" + packed()[14:]), "damaged"),
        (pcd("zipped", b""), "DATA 'zipped'"),
        (pcd("ascii", b"").replace(b"TYPE F", b"TYPE Q"), "type Q"),
        (pcd("ascii", BODIES["ascii"]).replace(b" z ", b" w "), "no field 'z'"),
        (b"# nothing\n", "no header"),
    ],
)
def test_pcd_that_is_damaged_is_refused(tmp_path, content, said):
    with pytest.raises(InputError) as caught:
        read(tmp_path, "a.pcd", content)
    assert said in str(caught.value)
    assert "a.pcd'" in str(caught.value)


@pytest.mark.parametrize("suffix", ["las", "laz"])
def test_las_with_an_offset_keeps_its_digits(tmp_path, suffix):
    laspy = pytest.importorskip("laspy")
    if suffix == "laz":
        pytest.importorskip("lazrs")
    header = laspy.LasHeader(point_format=3, version="1.2")
    header.offsets, header.scales = [5e5, 5.4e6, 300], [1e-4] * 3
    header.add_extra_dims([laspy.ExtraBytesParams(name, np.float32) for name in ("nx", "ny", "nz")])
    las = laspy.LasData(header)
    las.x, las.y, las.z = (POINTS + header.offsets).T
    las.nx, las.ny, las.nz = UNIT.T
    las.write(str(tmp_path / f"a.{suffix}"))
    found = read_points(tmp_path / f"a.{suffix}")
    assert np.allclose(found.points - [5e5, 5.4e6, 300], POINTS, atol=1e-8)
    assert np.allclose(found.normals, UNIT)
    with pytest.raises(InputError, match="cut short"):
        read(tmp_path, f"b.{suffix}", (tmp_path / f"a.{suffix}").read_bytes()[:-20])


@pytest.mark.parametrize("suffix", ["las", "laz"])
@pytest.mark.parametrize("version", [(0, 4), (2, 0), (1, 9)])
def test_las_of_no_known_version_is_refused(tmp_path, suffix, version):
    """laspy goes by the minor number: of a file of version 0.4 it read 155 million records, for minutes."""
    laspy = pytest.importorskip("laspy")
    las = laspy.LasData(laspy.LasHeader(point_format=6, version="1.4"))
    las.x, las.y, las.z = POINTS.T
    las.write(str(tmp_path / f"a.{suffix}"))
    content = bytearray((tmp_path / f"a.{suffix}").read_bytes())
    assert len(read(tmp_path, f"a.{suffix}", bytes(content)).points) == 4
    content[24:26] = bytes(version)
    with pytest.raises(InputError, match=rf"version {version[0]}\.{version[1]} of LAS"):
        read(tmp_path, f"a.{suffix}", bytes(content))


def test_las_without_its_package_says_how_to_get_it(tmp_path, monkeypatch):
    monkeypatch.setattr(las_clouds, "find_spec", lambda name: None)
    with pytest.raises(InputError) as caught:
        read(tmp_path, "a.las", b"LASF")
    assert pip_install("las") in str(caught.value)
