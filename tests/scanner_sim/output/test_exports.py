"""LAS, LAZ and E57, read back with the packages that define them for Python."""

import re

import numpy as np
import pytest

from datasets_gen import InputError
from datasets_gen.extras import pip_install
from scanner_sim import ScannerConfig, sample, scan
from scanner_sim.output import packages
from scanner_sim.output.e57 import write_e57
from scanner_sim.output.las import write_las


@pytest.fixture(scope="module")
def found(capsule):
    return scan(capsule, ScannerConfig(views=3, resolution=(80, 60), registration_error=0.5), seed=4)


@pytest.mark.parametrize("suffix", ["las", "laz"])
def test_las_has_every_attribute(found, suffix, tmp_path):
    laspy = pytest.importorskip("laspy")
    write_las(tmp_path / f"scan.{suffix}", found)
    las = laspy.read(tmp_path / f"scan.{suffix}")
    assert las.header.version == "1.4"
    step = np.ptp(found.points, axis=0).max() / 2**31
    assert np.abs(np.stack([las.x, las.y, las.z], axis=1) - found.points).max() < step
    assert np.abs(las.intensity / 65535 - found.intensity).max() <= 0.5 / 65535 + 1e-12
    assert np.array_equal(las.point_source_id, found.view_ids + 1)

    def columns(*names):
        return np.stack([las[name] for name in names], axis=1)

    assert np.array_equal(columns("nx", "ny", "nz"), found.normals.astype(np.float32))
    assert np.array_equal(columns("view", "face").T, [found.view_ids, found.face_ids])
    assert np.array_equal(columns("column", "row"), found.pixels)
    assert np.array_equal(columns("b0", "b1", "b2"), found.barycentrics)
    assert np.array_equal(columns("true_x", "true_y", "true_z"), found.true_points)
    assert np.array_equal(columns("angle", "width").T, [found.angle, found.width])
    text = next(v for v in las.header.vlrs if (v.user_id, v.record_id) == ("LASF_Spec", 3))
    assert b"frame: that of the scanned mesh" in text.record_data_bytes()
    assert f"{found.scale!r} mm".encode() in text.record_data_bytes()


def test_e57_has_a_posed_scan_per_view(found, tmp_path):
    """The reader applies the poses: points come back where the scan has them."""
    pye57 = pytest.importorskip("pye57")
    write_e57(tmp_path / "scan.e57", found)
    file = pye57.E57(str(tmp_path / "scan.e57"))
    assert file.scan_count == 3
    assert "frame: that of the scanned mesh" in file.root["coordinateMetadata"].value()
    for view in range(3):
        mine = found.select(found.view_ids == view)
        data = file.read_scan(view, intensity=True, row_column=True)
        points = np.stack([data[f"cartesian{axis}"] for axis in "XYZ"], axis=1)
        assert np.abs(points - mine.points).max() < 1e-12 * np.abs(mine.points).max()
        assert np.abs(data["intensity"] - mine.intensity).max() < 1e-7
        assert np.array_equal(np.stack([data["columnIndex"], data["rowIndex"]], axis=1), mine.pixels)
        assert np.allclose(file.scan_position(view)[0], found.poses[view, :3, 3], atol=1e-12)
        raw = file.read_scan_raw(view)
        assert raw["cartesianZ"].min() > 0  # in front of the camera
        assert "mesh" in file.data3d[view]["description"].value()
    file.close()


def test_e57_without_viewpoints_is_one_scan(capsule, tmp_path):
    pye57 = pytest.importorskip("pye57")
    ideal = sample(capsule, 200)
    write_e57(tmp_path / "ideal.e57", ideal)
    file = pye57.E57(str(tmp_path / "ideal.e57"))
    data = file.read_scan(0, ignore_missing_fields=True)
    assert np.allclose(np.stack([data[f"cartesian{axis}"] for axis in "XYZ"], axis=1), ideal.points)
    assert not file.get_header(0).has_pose()
    file.close()


def test_empty_scans(found, tmp_path):
    laspy = pytest.importorskip("laspy")
    nothing = found.select(np.arange(0))
    write_las(tmp_path / "none.las", nothing)
    assert len(laspy.read(tmp_path / "none.las").points) == 0
    pytest.importorskip("pye57")
    with pytest.raises(InputError, match="at least one point"):
        write_e57(tmp_path / "none.e57", nothing)
    assert not (tmp_path / "none.e57").exists()


@pytest.mark.parametrize(
    ("name", "write"), [("a.las", write_las), ("a.laz", write_las), ("a.e57", write_e57)]
)
def test_missing_packages_are_one_line(found, name, write, tmp_path, monkeypatch):
    monkeypatch.setattr(packages, "find_spec", lambda package: None)
    with pytest.raises(InputError, match=re.escape(pip_install("exports"))) as caught:
        write(tmp_path / name, found)
    assert "\n" not in str(caught.value)
    assert not (tmp_path / name).exists()
