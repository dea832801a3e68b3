"""Range images, read back with other programs."""

import json
import re
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from datasets_gen import InputError
from datasets_gen.extras import pip_install
from scanner_sim import Scan, ScannerConfig, sample, scan, write_range_images
from scanner_sim.output.range_images import range_image


@pytest.fixture(scope="module")
def found(capsule):
    return scan(capsule, ScannerConfig(views=3, resolution=(80, 60), registration_error=0.5), seed=4)


def test_range_images_and_cameras_give_the_points_back(found, capsule, tmp_path):
    """Depth along the pixel's ray, moved by the camera's pose, is the point before registration."""
    files = write_range_images(found, tmp_path / "ranges")
    record = json.loads(files[-1].read_text())
    camera = record["intrinsics"]
    clean = scan(capsule, replace(found.config, registration_error=0.0), seed=found.seed)
    for view, entry in enumerate(record["views"]):
        image = np.array(Image.open(tmp_path / "ranges" / entry["image"]))
        assert image.dtype == np.uint16
        assert image.shape == (60, 80)
        row, column = np.nonzero(image)
        assert len(row) == (found.view_ids == view).sum()
        depth = image[row, column] * record["depth_unit"]
        x = (column + 0.5 - camera["cx"]) / camera["fx"] * depth
        y = (row + 0.5 - camera["cy"]) / camera["fy"] * depth
        pose = np.array(entry["camera_to_mesh"])
        points = np.stack([x, y, depth], axis=1) @ pose[:3, :3].T + pose[:3, 3]
        mine = clean.view_ids == view
        order = np.lexsort(clean.pixels[mine].T)
        assert np.abs(points - clean.points[mine][order]).max() < record["depth_unit"]


def test_transforms_are_opengl_cameras(found, capsule, tmp_path):
    """As programs of the NeRF family read it: rays (x, -y, -1) of the pixel, placed by the matrix."""
    write_range_images(found, tmp_path)
    record = json.loads((tmp_path / "transforms.json").read_text())
    assert record["camera_model"] == "OPENCV"
    assert record["camera_angle_x"] == pytest.approx(np.radians(found.config.field_of_view))
    assert (record["w"], record["h"], record["k1"], record["k2"]) == (80, 60, 0.0, 0.0)
    clean = scan(capsule, replace(found.config, registration_error=0.0), seed=found.seed)
    for view, frame in enumerate(record["frames"]):
        image = np.array(Image.open(tmp_path / frame["file_path"]))
        row, column = np.nonzero(image)
        depth = image[row, column] * record["depth_unit_scale_factor"]
        x = (column + 0.5 - record["cx"]) / record["fl_x"]
        y = (row + 0.5 - record["cy"]) / record["fl_y"]
        matrix = np.array(frame["transform_matrix"])
        points = (
            np.stack([x, -y, -np.ones(len(x))], axis=1) * depth[:, None] @ matrix[:3, :3].T + matrix[:3, 3]
        )
        mine = clean.view_ids == view
        order = np.lexsort(clean.pixels[mine].T)
        assert np.abs(points - clean.points[mine][order]).max() < record["depth_unit_scale_factor"]
        assert np.linalg.det(matrix[:3, :3]) == pytest.approx(1)
    assert "frame" in record


def test_second_cameras_have_images_of_their_own(capsule, tmp_path):
    both = scan(capsule, ScannerConfig(views=2, resolution=(60, 60), cameras=2), seed=4)
    write_range_images(both, tmp_path)
    frames = json.loads((tmp_path / "transforms.json").read_text())["frames"]
    assert len(frames) == len(both.poses) == 4
    for view, pose in enumerate(both.poses):
        mine = both.select(both.view_ids == view)
        depth = ((mine.points - pose[:3, 3]) @ pose[:3, :3])[:, 2]
        assert len(mine) > 50
        image = range_image(both, view)
        assert np.allclose(image[mine.pixels[:, 1], mine.pixels[:, 0]], depth, rtol=1e-9)


def test_lenses_of_transforms_are_those_of_the_scan(capsule, tmp_path):
    config = ScannerConfig(views=1, resolution=(40, 40), distortion=(-0.1, 0.02))
    write_range_images(scan(capsule, config, seed=0), tmp_path)
    record = json.loads((tmp_path / "transforms.json").read_text())
    assert (record["k1"], record["k2"]) == (-0.1, 0.02)


def test_profilers_have_no_range_images(found, tmp_path):
    profiler = replace(found, config=replace(found.config, motion="profiler"))
    with pytest.raises(InputError, match="profiler"):
        write_range_images(profiler, tmp_path / "none")
    assert not (tmp_path / "none").exists()


def test_exr_without_its_package_is_one_line(found, tmp_path, monkeypatch):
    monkeypatch.setattr("scanner_sim.output.range_images.find_spec", lambda name: None)
    with pytest.raises(InputError, match=re.escape(pip_install("exr"))):
        write_range_images(found, tmp_path / "none", ".exr")
    assert not (tmp_path / "none").exists()


def test_exr_holds_depths_in_mesh_units(found, tmp_path):
    import OpenEXR

    files = write_range_images(found, tmp_path, ".exr")
    image = OpenEXR.File(str(files[0])).channels()["Y"].pixels
    assert np.allclose(image, range_image(found, 0), rtol=1e-6)


def test_scans_without_views_have_no_range_images(capsule, tmp_path):
    with pytest.raises(InputError, match="viewpoints"):
        write_range_images(sample(capsule, 50), tmp_path)
    with pytest.raises(InputError, match="jpg"):
        write_range_images(sample(capsule, 50), tmp_path, ".jpg")


def test_unwritable_targets_are_one_line(found, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write"):
        found.save(tmp_path / "file" / "scan.ply")
    with pytest.raises(InputError, match="not a readable"):
        Scan.load(tmp_path / "file")
