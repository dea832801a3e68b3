"""Presets, further formats and the complete truth from the command line."""

import json

import numpy as np
import pytest
import trimesh

from datasets_gen.extras import pip_install
from scanner_sim import Scan, ScannerConfig, presets
from scanner_sim.output import packages
from tests.reports.cli.command_line import SMALL, fails, run

FEW = ("--set", "resolution=[60,60]", "--views", 2)


def test_presets_come_before_options(mesh_file, tmp_path):
    out = tmp_path / "s.npz"
    result = run("scan", mesh_file, "-o", out, "--preset", "vivid-910-tele", *FEW, "--set", "stripes=800")
    assert result.exit_code == 0, result.output
    config = Scan.load(out).config
    expected = ScannerConfig.preset("vivid-910-tele", resolution=(60, 60), views=2, stripes=800)
    assert config == expected
    assert config.wavelength == 690.0


def test_files_are_presets_and_bad_ones_are_one_line(mesh_file, tmp_path):
    mine, out = tmp_path / "mine.toml", tmp_path / "s.npz"
    mine.write_text("[scanner]\nbaseline = -40\nresolution = [60, 60]\nviews = 2\n")
    assert run("scan", mesh_file, "-o", out, "--preset", mine).exit_code == 0
    assert Scan.load(out).config.baseline == -40
    mine.write_text("[scanner]\nbase_line = -40\n")
    out.unlink()
    fails(run("scan", mesh_file, "-o", out, "--preset", mine), "base_line", "baseline")
    fails(run("scan", mesh_file, "-o", out, "--preset", "vivid"), "vivid", "known presets")
    fails(run("scan", mesh_file, "-o", out, "--preset", tmp_path / "none.toml"), "none.toml")
    assert not out.exists()


def test_help_names_the_presets():
    words = run("scan", "--help").output.split()
    assert set(presets.names()) <= {word.strip(",;") for word in words}


def test_truth_and_transforms(mesh_file, tmp_path):
    truth, out = tmp_path / "truth.ply", tmp_path / "s.npz"
    result = run(
        "scan", mesh_file, "-o", out, *SMALL, "--truth", truth, "--range-images", tmp_path / "ranges"
    )
    assert result.exit_code == 0, result.output
    data = trimesh.load(truth).metadata["_ply_raw"]["vertex"]["data"]
    missing = 100 * (1 - np.asarray(data["seen"]).mean())
    printed = float(result.output.split(" % of the surface")[0].split()[-1])
    assert missing == pytest.approx(printed, abs=3)
    cameras = json.loads((tmp_path / "ranges" / "transforms.json").read_text())
    assert len(cameras["frames"]) == len(Scan.load(out).poses)


def test_truth_does_not_overwrite_the_scan(mesh_file, tmp_path):
    path = tmp_path / "s.ply"
    fails(run("scan", mesh_file, "-o", path, *SMALL, "--truth", path), "--truth", status=2)
    fails(run("scan", mesh_file, "-o", path, *SMALL, "--truth", tmp_path / "t.npz"), "t.npz")
    assert not path.exists()


@pytest.mark.parametrize(("suffix", "package"), [("las", "laspy"), ("laz", "lazrs"), ("e57", "pye57")])
def test_further_formats(suffix, package, mesh_file, tmp_path, monkeypatch):
    pytest.importorskip(package)
    out = tmp_path / f"s.{suffix}"
    result = run("scan", mesh_file, "-o", out, *SMALL)
    assert result.exit_code == 0, result.output
    assert out.read_bytes()[:8].startswith(b"ASTM-E57" if suffix == "e57" else b"LASF")
    monkeypatch.setattr(packages, "find_spec", lambda name: None)
    fails(run("scan", mesh_file, "-o", tmp_path / f"none.{suffix}", *SMALL), pip_install("exports"))
    assert not (tmp_path / f"none.{suffix}").exists()
