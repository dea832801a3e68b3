"""Files for other programs, read back with other programs."""

import json
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from PIL import Image

from datasets_gen import InputError
from scanner_sim import Scan, ScannerConfig, preview, sample, scan, write_range_images
from scanner_sim.optics.measurement import Verdict, verdicts
from scanner_sim.scanner import Rig


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


def test_exr_without_its_package_is_one_line(found, tmp_path, monkeypatch):
    monkeypatch.setattr("scanner_sim.output.export.find_spec", lambda name: None)
    with pytest.raises(InputError, match="pip install OpenEXR"):
        write_range_images(found, tmp_path / "none", ".exr")
    assert not (tmp_path / "none").exists()


def test_exr_holds_depths_in_mesh_units(found, tmp_path):
    import OpenEXR

    from scanner_sim.output.export import range_image

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


def test_preview_is_a_picture_of_its_view(torus, tmp_path):
    config = ScannerConfig(views=3, resolution=(80, 80), noise=0.1)
    preview(torus, tmp_path / "sheet.png", config, view=1)
    image = np.array(Image.open(tmp_path / "sheet.png"))
    assert image.shape[0] > 600
    assert image.shape[1] > 900
    assert len(np.unique(image.reshape(-1, image.shape[2]), axis=0)) > 500
    with pytest.raises(InputError, match="no view 3"):
        preview(torus, tmp_path / "none.png", config, view=3)
    assert not (tmp_path / "none.png").exists()


def judged(shape, **settings):
    rig = Rig(shape, ScannerConfig(resolution=(60, 60), shading="flat", **settings))
    hits, measured = rig.view(0, seed=0)
    return verdicts(hits, measured, rig.config)


@pytest.mark.parametrize(
    ("settings", "most"),
    [
        ({}, Verdict.ACCEPTED),
        ({"material": "black"}, Verdict.DARK),
        ({"exposure": 20.0}, Verdict.SATURATED),
        ({"distance": 400.0}, Verdict.OUT_OF_RANGE),
        ({"residual_threshold": 1e-9}, Verdict.POOR_FIT),
        ({"depth_threshold": 1e-9}, Verdict.POOR_FIT),
        ({"views": ((1, 0, 0.35),)}, Verdict.GRAZING),
    ],
)
def test_verdicts_name_the_reason(plate, settings, most):
    verdict = judged(plate, **{"views": ((0, 0, 1),), **settings})
    assert np.bincount(verdict, minlength=8).argmax() == most


def test_verdict_of_hidden_pixels_is_shadow(torus):
    assert (judged(torus, views=((1, 0, 0.3),)) == Verdict.SHADOW).any()
