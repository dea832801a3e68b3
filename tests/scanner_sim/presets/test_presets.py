"""Presets against the figures of the data sheets that they name."""

from dataclasses import asdict, fields
from importlib.resources import files

import numpy as np
import pytest
import trimesh

from datasets_gen import InputError
from scanner_sim import presets, scan
from scanner_sim.scanner_config import ScannerConfig
from tests.scanner_sim.conftest import to_shape

KNOWN = [field.name for field in fields(ScannerConfig)]
DEVICES = [name for name in presets.names() if name != "reference"]
STATED = [name for name in DEVICES if "accuracy" in presets.about(name)]
FIELDS = {  # mm: distance from the pinhole, and width (profilers: length of the line) of the field there
    "vivid-910-tele": (600, 83),
    "vivid-910-middle": (600, 148),
    "vivid-910-wide": (600, 269),
    "nextengine-macro": (6.5 * 25.4, 5.1 * 25.4),
    "nextengine-wide": (17 * 25.4, 13.5 * 25.4),
    "fabscan": (309, 266),
    "scancontrol-2900-50": (61 + 120, 58),
    "lj-v7080": (25 + 103, 39),
}


def coarse(name, frames=14, **changes):
    """A preset with few pixels, or, as a profiler's noise depends on them, few frames."""
    config = ScannerConfig.preset(name)
    if config.motion == "profiler":
        return ScannerConfig.preset(name, profile_step=config.object_size / frames, **changes)
    return ScannerConfig.preset(name, resolution=[side // 4 for side in config.resolution], **changes)


def test_there_are_the_reference_and_real_devices():
    assert "reference" in presets.names()
    assert len(DEVICES) >= 4
    for name in DEVICES:
        about = presets.about(name)
        assert {"name", "source", "states", "chosen"} <= set(about)


@pytest.mark.parametrize("name", presets.names())
def test_each_preset_scans_a_sphere(name):
    sphere = to_shape(trimesh.creation.icosphere(subdivisions=4, radius=2.0), "test/sphere")
    found = scan(sphere, coarse(name, 4, views=((0.0, 0.3, 1.0),), normals="true"), seed=1)
    assert len(found) > 500
    radial = np.linalg.norm(found.points, axis=1) - np.linalg.norm(found.true_points, axis=1)
    assert np.abs(np.median(radial)) * found.scale < 0.1  # mm
    assert np.sqrt((radial**2).mean()) * found.scale < 1.0


@pytest.mark.parametrize("name", FIELDS)
def test_field_of_view_is_that_of_the_data_sheet(name):
    config, (distance, field) = ScannerConfig.preset(name), FIELDS[name]
    pixels = config.resolution[1] if config.motion == "profiler" else config.resolution[0]
    assert distance * pixels / config.focal == pytest.approx(field, rel=0.02)


@pytest.mark.parametrize("name", STATED)
def test_depth_noise_is_the_stated_accuracy(name):
    """Twice the standard deviation of depth on a white plate that faces the camera at the stated distance.

    The same as ``medialbench scan plate.ply --preset NAME --views '[[0,0,1]]' --set distance=...``.
    """
    about = presets.about(name)
    plate = to_shape(trimesh.creation.box((70.0, 70.0, 2.0)), "test/plate")
    config = coarse(name, views=((0.0, 0.0, 1.0),), distance=about["accuracy_distance"])
    found = scan(plate, config, seed=2)
    residual = (found.points - found.true_points)[:, 2] * found.scale
    inner = (np.abs(found.true_points[:, :2]) < 25).all(axis=1)  # a line half on the plate is biased
    assert inner.sum() > 1000
    assert 2 * residual[inner].std() == pytest.approx(about["accuracy"], rel=0.15)
    assert abs(residual[inner].mean()) < 0.1 * about["accuracy"]


def test_the_reference_has_the_settings_of_its_measured_tables():
    config = ScannerConfig.preset("reference")
    assert (config.resolution, config.baseline, config.views) == ((400, 400), -50.0, 9)
    assert (config.min_range, config.max_range, config.depth_threshold) == (70.0, 300.0, 4.0)
    assert (config.fit, config.quantisation, config.smoothing_stage) == ("reference", "truncate", "image")
    assert (config.normals, config.neighbours) == ("pca_true_sign", 11)


@pytest.mark.parametrize("name", DEVICES)
def test_every_figure_has_its_source_or_says_that_there_is_none(name):
    text = (files(presets) / f"{name}.toml").read_text("utf-8")
    for line in text.split("[scanner]")[1].strip().splitlines():
        assert "#" in line or line.startswith(("beam =", "motion =")), line


def test_changes_come_after_the_preset():
    changed = ScannerConfig.preset("vivid-910-tele", noise=0.1, views=3)
    assert (changed.noise, changed.views, changed.baseline) == (0.1, 3, 200.0)
    expanded = presets.expanded({"noise": 0.1, "preset": "vivid-910-tele", "views": 3})
    assert "preset" not in expanded
    assert ScannerConfig.from_dict(expanded) == changed
    assert presets.expanded({"noise": 0.1}) == {"noise": 0.1}


def test_a_file_of_the_user_is_a_preset_too(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text('about = {name = "mine"}\n[scanner]\nbaseline = 80\nresolution = [64, 48]\n')
    assert presets.about(path)["name"] == "mine"
    assert ScannerConfig.preset(path) == ScannerConfig(baseline=80, resolution=(64, 48))
    assert ScannerConfig.from_dict(asdict(ScannerConfig.preset(path))) == ScannerConfig.preset(path)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[scanner]\nbase_line = 3\n", ["base_line", "did you mean 'baseline'"]),
        ("baseline = 3\n", ["baseline", r"\[scanner\]"]),
        ("[about]\nname = 'x'\n", [r"lacks a table \[scanner\]"]),
        ("[scanner\n", ["not valid TOML"]),
        ("[scanner]\nbaseline = 0\n", ["baseline", "not be 0"]),
    ],
)
def test_bad_files_are_one_line(text, words, tmp_path):
    path = tmp_path / "bad.toml"
    path.write_text(text)
    for word in words:
        with pytest.raises(InputError, match=word) as caught:
            ScannerConfig.from_dict(presets.expanded({"preset": path}, KNOWN))
        assert "\n" not in str(caught.value)


def test_unknown_presets_name_the_nearest(tmp_path):
    with pytest.raises(InputError, match=r"vivid-911-tele.*did you mean 'vivid-910-tele'.*reference"):
        presets.load("vivid-911-tele")
    with pytest.raises(InputError, match="cannot read the preset"):
        presets.load(tmp_path / "none.toml")
    with pytest.raises(InputError, match="got 3"):
        presets.expanded({"preset": 3})
