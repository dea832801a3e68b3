"""``medialbench score`` on a sphere, with the files of a template and of a symmetric truth."""

import csv
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from click.testing import CliRunner
from scipy.spatial import cKDTree

from datasets_gen import load, write_mesh
from reports.cli.main import cli
from scanner_sim import sample


@pytest.fixture
def sphere(tmp_path):
    trimesh.creation.icosphere(3).export(tmp_path / "ball.off")
    return tmp_path / "ball.off"


def scored(*words):
    result = CliRunner().invoke(cli, ["score", *map(str, words)])
    table = dict(
        line.rsplit(maxsplit=1) for line in result.output.splitlines() if line[:1].islower() or "PCK" in line
    )
    return result, table


def test_a_map_of_shared_vertices(sphere, tmp_path):
    np.savetxt(tmp_path / "a.map", np.arange(642), fmt="%d")
    result, table = scored(tmp_path / "a.map", "--target", sphere, "-o", tmp_path / "errors.csv")
    assert result.exit_code == 0, result.output
    assert (table["points"], table["mean"], table["matched %"]) == ("642", "0.000", "100.000")
    rows = list(csv.DictReader((tmp_path / "errors.csv").open()))
    assert len(rows) == 642
    assert all(float(row["error"]) < 1e-6 for row in rows)


def test_a_pair_of_vts_files_and_their_mirror_images(sphere, tmp_path):
    """The template's points 1, 2, 3 are vertices 3, 1, 2 of the source and 10, 20, 30 of the target."""
    for name, ids in (("a", [3, 1, 2]), ("b", [10, 20, 30]), ("a.sym", [3, 1, 2]), ("b.sym", [30, 20, 10])):
        np.savetxt(tmp_path / f"{name}.vts", ids, fmt="%d")
    np.savetxt(tmp_path / "found.txt", [19, 9, 29], fmt="%d", header="first_id = 0")  # swaps 10 and 30
    files = {"--truth": ("a.vts", "b.vts"), "--mirrored": ("a.sym.vts", "b.sym.vts")}
    options = [
        word for option, names in files.items() for name in names for word in (option, tmp_path / name)
    ]
    result, table = scored(tmp_path / "found.txt", "--target", sphere, *options)
    assert result.exit_code == 0, result.output
    assert (table["symmetric mean"], table["flipped"]) == ("0.000", "True")
    assert float(table["mean"]) > 1


def test_what_is_missing_is_said_in_one_line(sphere, tmp_path):
    np.savetxt(tmp_path / "a.txt", np.arange(642), fmt="%d")
    result, _ = scored(tmp_path / "a.txt", "--target", sphere)
    assert result.exit_code == 1
    assert "does not say whether indices count from 0 or 1" in result.output
    np.savetxt(tmp_path / "b.map", np.arange(5), fmt="%d")
    result, _ = scored(tmp_path / "b.map", "--target", sphere)
    assert "the map has 5 points and the target 642 vertices" in result.output
    assert "--truth" in result.output


def test_scans_hold_the_truth_of_a_map_between_them(tmp_path):
    body = load("dumbbell")
    write_mesh(body.reference, tmp_path / "rest.ply")
    source, target = (sample(body.reference, count, seed=count) for count in (300, 200))
    source.save(tmp_path / "a.npz")
    target.save(tmp_path / "b.npz")
    nearest = cKDTree(target.true_points).query(source.true_points)[1]
    np.save(tmp_path / "near.npy", nearest)
    np.save(tmp_path / "far.npy", np.roll(nearest, 7))
    np.save(tmp_path / "some.npy", np.where(np.arange(300) % 3 == 0, -1, nearest))
    scans = "--target", tmp_path / "rest.ply", "--scans", tmp_path / "a.npz", tmp_path / "b.npz"
    tables = {}
    for name in ("near", "far", "some"):
        result, tables[name] = scored(tmp_path / f"{name}.npy", *scans)
        assert result.exit_code == 0, result.output
    least = float(tables["near"]["least mean"])
    assert 0 < least <= float(tables["near"]["mean"]) < 1.2 * least
    assert float(tables["far"]["mean"]) > 5 * least
    assert tables["far"]["least mean"] == tables["near"]["least mean"]
    assert tables["some"]["matched %"] == "66.667"
    result, _ = scored(tmp_path / "near.npy", *scans, "--truth", tmp_path / "near.npy")
    assert "leave out --truth" in result.output
    np.savez(tmp_path / "held.npz", source_to_target=nearest % 200, source_points=source.points)
    assert scored(tmp_path / "held.npz", *scans)[0].exit_code == 0
    np.savez(tmp_path / "held.npz", source_to_target=nearest % 200, target_points=source.points[:200])
    result, _ = scored(tmp_path / "held.npz", *scans)
    assert "the map was made of another target" in result.output
    for kind in (bool, complex):
        np.save(tmp_path / "kind.npy", nearest.astype(kind))
        assert "are no indices; give whole numbers" in scored(tmp_path / "kind.npy", *scans)[0].output
    write_mesh(load("capsule_chain").reference, tmp_path / "other.ply")
    other = "--target", tmp_path / "other.ply", *scans[2:]
    result, _ = scored(tmp_path / "near.npy", *other)
    assert "the mesh is no pose of the subject of the scan of 'dumbbell/" in result.output
    replace(target, shape_name="torus/rest").save(tmp_path / "torus.npz")
    result, _ = scored(tmp_path / "near.npy", *scans[:-1], tmp_path / "torus.npz")
    assert "the scans are of 'dumbbell' and 'torus'" in result.output
    np.save(tmp_path / "short.npy", nearest[:9])
    result, _ = scored(tmp_path / "short.npy", *scans)
    assert "the map has 9 points, the source scan 300" in result.output
    np.save(tmp_path / "beyond.npy", nearest + 200)
    result, _ = scored(tmp_path / "beyond.npy", *scans)
    assert "of a target of 200 points" in result.output
