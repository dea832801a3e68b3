"""The complete truth beside a scan, read back with another program."""

import numpy as np
import pytest
import trimesh

from datasets_gen import InputError
from scanner_sim import ScannerConfig, coverage, scan
from scanner_sim.output.truth import survival, write_truth


@pytest.fixture(scope="module")
def found(fine_sphere):
    return scan(fine_sphere, ScannerConfig(views=((0.0, 0.0, 1.0),), resolution=(150, 150)), seed=0)


def read(path):
    data = trimesh.load(path).metadata["_ply_raw"]["vertex"]["data"]
    return {name: np.asarray(data[name]).ravel() for name in data.dtype.names}


def test_labels_say_what_is_missing(found, fine_sphere, tmp_path):
    missing = write_truth(tmp_path / "truth.ply", found, fine_sphere, points=4000)
    data = read(tmp_path / "truth.ply")
    assert len(data["x"]) == 4000
    assert missing == pytest.approx(1 - data["seen"].mean())
    assert missing == pytest.approx(1 - coverage(found, fine_sphere), abs=0.03)
    assert np.abs(np.sqrt(data["x"] ** 2 + data["y"] ** 2 + data["z"] ** 2) - 37.5).max() < 0.02
    radius = 0.01 * np.sqrt(3) * 75
    assert np.array_equal(data["seen"] == 1, data["distance"] <= radius)
    assert np.array_equal(data["seen"] == 1, data["threshold"] > 0)
    assert np.array_equal(data["seen"] == 1, data["green"] > data["red"])
    header = (tmp_path / "truth.ply").read_bytes().split(b"end_header")[0]
    assert b"frame: that of the scanned mesh" in header


def test_the_camera_sees_its_cap_of_a_sphere(found, fine_sphere, tmp_path):
    """From a distance D a sphere of radius R is seen where z > R^2 / D; the laser sees no more."""
    write_truth(tmp_path / "truth.ply", found, fine_sphere, points=4000)
    data = read(tmp_path / "truth.ply")
    eye = np.linalg.norm(found.poses[0, :3, 3])
    horizon = 37.5**2 / eye
    assert not data["seen"][data["z"] < horizon - 1.5].any()
    facing = data["z"] > 0.85 * 37.5  # also seen by the laser, at cosines far above the threshold
    assert data["seen"][facing].all()


def test_thresholds_are_those_of_a_sweep(found, fine_sphere):
    """A place is still seen by the scan accepted at tau just if its threshold reaches tau."""
    places = fine_sphere.vertices[::40]
    _, threshold = survival(places, found, 1.0)
    for tau in (0.3, 0.6, 0.9):
        some = found.accept(tau)
        distance, _ = survival(places, some, 1.0)
        assert np.array_equal(threshold >= tau, distance <= 1.0)


def test_nothing_seen_and_bad_radii(found, fine_sphere, tmp_path):
    nothing = found.select(np.arange(0))
    assert write_truth(tmp_path / "none.ply", nothing, fine_sphere, points=100) == 1.0
    assert (read(tmp_path / "none.ply")["distance"] == -1).all()
    with pytest.raises(InputError, match="radius"):
        write_truth(tmp_path / "bad.ply", found, fine_sphere, radius=0.0)
    assert not (tmp_path / "bad.ply").exists()
