"""Point clouds for other programs, read back with another program."""

import numpy as np
import pytest
import trimesh

from scanner_sim import ScannerConfig, scan
from scanner_sim.output.ply import write_points


@pytest.fixture(scope="module")
def found(capsule):
    return scan(capsule, ScannerConfig(views=3, resolution=(80, 60), registration_error=0.5), seed=4)


def test_ply_read_by_trimesh_has_every_attribute(found, tmp_path):
    found.save(tmp_path / "scan.ply")
    cloud = trimesh.load(tmp_path / "scan.ply")
    assert np.array_equal(cloud.vertices, found.points)
    data = cloud.metadata["_ply_raw"]["vertex"]["data"]

    def column(*names):
        return np.stack([np.asarray(data[name]).ravel() for name in names], axis=1)

    assert np.array_equal(column("nx", "ny", "nz"), found.normals.astype(np.float32))
    assert np.array_equal(column("intensity")[:, 0], found.intensity.astype(np.float32))
    assert np.array_equal(column("quality"), column("intensity"))
    assert np.array_equal(column("view")[:, 0], found.view_ids)
    assert np.array_equal(column("face")[:, 0], found.face_ids)
    assert np.array_equal(column("column", "row"), found.pixels)
    assert np.array_equal(column("b0", "b1", "b2"), found.barycentrics)
    assert np.array_equal(column("true_x", "true_y", "true_z"), found.true_points)
    assert np.array_equal(column("angle", "width"), np.stack([found.angle, found.width], axis=1))


def test_ply_header_lines_are_short_enough_for_other_readers(found, tmp_path):
    found.save(tmp_path / "scan.ply")
    header = (tmp_path / "scan.ply").read_bytes().split(b"end_header")[0]
    assert max(map(len, header.split(b"\n"))) < 200
    assert header.startswith(b"ply\nformat binary_little_endian 1.0\n")


def test_no_points_are_a_file_too(found, tmp_path):
    found.select(np.arange(0)).save(tmp_path / "empty.ply")
    assert b"element vertex 0\n" in (tmp_path / "empty.ply").read_bytes()


def test_properties_keep_their_order_and_type(tmp_path):
    values = {"b": np.arange(3, dtype=">f8"), "a": np.arange(3, dtype=np.int32)}
    write_points(tmp_path / "few.ply", values, ["caf\u00e9"])
    content = (tmp_path / "few.ply").read_bytes()
    assert b"comment caf?\nelement vertex 3\nproperty double b\nproperty int a\nend_header\n" in content
    rows = np.frombuffer(content.split(b"end_header\n")[1], dtype=[("b", "<f8"), ("a", "<i4")])
    assert rows["b"].tolist() == rows["a"].tolist() == [0, 1, 2]
