"""The command line: what it does, and that bad input ends in one line with nothing written."""

import json
import subprocess
import sys

import numpy as np
import pytest
import trimesh
from click.testing import CliRunner

import scanner_sim
from datasets_gen.records import load_record
from reports.cli.main import COMMANDS, cli
from scanner_sim import Scan

SMALL = ["--set", "resolution=[60, 60]", "--set", "stripes=80", "--views", "4"]


def run(*arguments):
    return CliRunner().invoke(cli, [str(a) for a in arguments])


def fails(result, *words, status=1):
    """One line on standard error that holds some words, and a status."""
    assert result.exit_code == status, result.output
    assert isinstance(result.exception, SystemExit)
    lines = result.stderr.strip().splitlines()
    assert len(lines) == 1, result.stderr
    assert lines[0].startswith("medialbench: ")
    assert "Traceback" not in result.output
    for word in words:
        assert word in lines[0], lines[0]


def body():
    """A closed surface without symmetry: a bent club with two bumps."""
    mesh = trimesh.creation.icosphere(subdivisions=3)
    v = np.array(mesh.vertices) * [0.5, 1.5, 0.4]
    v[:, 0] += 0.25 * v[:, 1] ** 2 + 0.1 * v[:, 1]
    v[:, 2] *= 1 + 0.4 * np.tanh(v[:, 1])
    return trimesh.Trimesh(v, mesh.faces, process=False)


@pytest.fixture(scope="module")
def mesh_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("mesh") / "body.ply"
    body().export(path)
    return path


@pytest.fixture(scope="module")
def scan_file(mesh_file, tmp_path_factory):
    path = tmp_path_factory.mktemp("scan") / "body.npz"
    result = run("scan", mesh_file, "-o", path, *SMALL, "-t", "0.3", "--points", 600)
    assert result.exit_code == 0, result.output
    return path


# ---------------------------------------------------------------------------- all commands


def test_help_starts_without_heavy_libraries():
    code = (
        "import sys; from click.testing import CliRunner; from reports.cli.main import cli;"
        "result = CliRunner().invoke(cli, ['--help']); assert result.exit_code == 0;"
        "heavy = ('numpy', 'scipy', 'mitsuba', 'pandas', 'matplotlib', 'dask');"
        "print([m for m in heavy if m in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_help_lists_every_command_with_a_sentence():
    lines = run("--help").output.splitlines()
    for name in COMMANDS:
        line = next(line for line in lines if line.split()[:1] == [name])
        assert line.rstrip().endswith(".")
        assert not line.rstrip().endswith("...")


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_has_the_common_options(name):
    text = run(name, "--help").output
    for option in ("--quiet", "--debug", "--help"):
        assert option in text


def test_wrong_usage_is_one_line():
    fails(run("scam"), "scam", "--help", status=2)
    fails(run("scan", "--colour", "x.ply"), "--colour", "medialbench scan --help", status=2)
    fails(run("scan", "x.ply"), "--out", status=2)
    fails(run("report"), "DIR", status=2)
    fails(run("report", "x", "--pairs", "many"), "many", status=2)
    fails(run("scan", "x.ply", "-o", "y.npz", "--points", "0"), "0", status=2)


def test_unexpected_errors_are_one_line_and_whole_with_debug(monkeypatch, mesh_file, tmp_path):
    def broken(*_):
        raise RuntimeError("no\nluck")

    monkeypatch.setattr(scanner_sim, "scan", broken)
    out = tmp_path / "o.npz"
    fails(run("scan", mesh_file, "-o", out), "RuntimeError", "no luck", "--debug")
    result = run("scan", mesh_file, "-o", out, "--debug")
    assert isinstance(result.exception, RuntimeError)
    assert not out.exists()


def test_the_installed_command_ends_with_a_status_and_one_line(tmp_path):
    done = subprocess.run(
        [sys.executable, "-m", "reports.cli.main", "scan", "no.ply", "-o", "x.npz"],
        capture_output=True,
        text=True,
        cwd=tmp_path,
        check=False,
    )
    assert done.returncode == 1
    assert done.stdout == ""
    assert done.stderr == "medialbench: 'no.ply' does not exist; give a mesh file\n"
    assert list(tmp_path.iterdir()) == []


# ---------------------------------------------------------------------------- doctor, datasets


def test_doctor_names_variants_and_methods():
    result = run("doctor", "-q")
    assert result.exit_code == 0, result.output
    variants, devices = ("scalar_rgb", "llvm_ad_rgb", "cuda_ad_rgb"), ("device cpu", "device cuda")
    for word in (*variants, *devices, "medial", "heat", "mitsuba", "Python"):
        assert word.lower() in result.output.lower()


def test_doctor_survives_a_broken_scanner(monkeypatch):
    from scanner_sim.tracing import variant

    def broken():
        raise OSError("no Mitsuba")

    monkeypatch.setattr(variant, "variant_report", broken)
    result = run("doctor", "-q")
    assert result.exit_code == 1
    assert "Traceback" not in result.output
    assert "no Mitsuba" in result.stderr
    assert "medial" in result.stdout


def test_a_folder_of_poses_is_shown_and_written(tmp_path):
    folder = tmp_path / "poses"
    folder.mkdir()
    for pose in ("rest", "bent"):
        body().export(folder / f"{pose}.ply")
    assert run("datasets", folder, "-q").stdout.split() == ["poses/bent", "poses/rest"]
    out = tmp_path / "out"
    result = run("datasets", folder, "-o", out)
    assert result.exit_code == 0, result.output
    assert sorted(path.name for path in out.iterdir()) == ["bent.ply", "manifest.json", "rest.ply"]
    assert json.loads((out / "manifest.json").read_text())["reference"] == "rest"


def test_unknown_datasets_name_the_nearest():
    fails(run("datasets", "humn"), "humn", "'human'")
    fails(run("datasets", "-o", "x"), "human", status=2)


# ---------------------------------------------------------------------------- scan


def test_scan_writes_all_that_a_scan_knows(scan_file):
    scan = Scan.load(scan_file)
    assert len(scan) == 600
    assert scan.config.peak_threshold == 0.3
    assert scan.config.resolution == (60, 60)
    assert scan.config.views == 4
    assert (scan.intensity >= 0.3).all()


def test_quiet_scans_say_nothing_and_repeat_exactly(mesh_file, tmp_path):
    files = [tmp_path / "a.npz", tmp_path / "b.npz"]
    for path in files:
        result = run("scan", mesh_file, "-o", path, *SMALL, "--set", "noise=0.2", "--seed", 5, "-q")
        assert result.exit_code == 0
        assert result.output == ""
    a, b = map(Scan.load, files)
    assert np.array_equal(a.points, b.points)
    assert np.array_equal(a.intensity, b.intensity)


def test_scan_writes_ply_preview_and_range_images(mesh_file, tmp_path):
    result = run(
        "scan", mesh_file, "-o", tmp_path / "s.ply", *SMALL, "--preview", tmp_path / "sheet.png",
        "--range-images", tmp_path / "ranges",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    cloud = trimesh.load(tmp_path / "s.ply")
    assert np.abs(cloud.vertices).max() < 2.5
    assert (tmp_path / "sheet.png").read_bytes()[:4] == b"\x89PNG"
    assert "cameras.json" in [path.name for path in (tmp_path / "ranges").iterdir()]


def with_nan(mesh):
    mesh.vertices[3] = np.nan
    return mesh


def with_flat_face(mesh):
    return trimesh.Trimesh(mesh.vertices, np.vstack([mesh.faces, [[0, 0, 1]]]), process=False)


def non_manifold(mesh):
    faces = np.vstack([mesh.faces, [[mesh.faces[0][0], mesh.faces[0][1], 100]]])
    return trimesh.Trimesh(mesh.vertices, faces, process=False)


def in_two_parts(mesh):
    other = mesh.copy()
    other.apply_translation([5, 0, 0])
    return trimesh.util.concatenate([mesh, other])


BAD_MESHES = {
    "NaN": (with_nan, "NaN"),
    "degenerate": (with_flat_face, "degenerate"),
    "non-manifold": (non_manifold, "non-manifold"),
    "two components": (in_two_parts, "components"),
}


@pytest.mark.parametrize("name", BAD_MESHES)
def test_bad_meshes_are_refused(name, tmp_path):
    spoil, word = BAD_MESHES[name]
    path, out = tmp_path / "bad.ply", tmp_path / "out" / "scan.npz"
    spoil(body()).export(path)
    fails(run("scan", path, "-o", out, *SMALL), word)
    assert not out.parent.exists()


def test_files_that_are_no_meshes_are_refused(tmp_path, scan_file):
    out = tmp_path / "scan.npz"
    (tmp_path / "cloud.ply").write_text(
        "ply\nformat ascii 1.0\nelement vertex 1\n"
        "property float x\nproperty float y\nproperty float z\nend_header\n0 0 0\n"
    )
    (tmp_path / "text.obj").write_bytes(b"\x00\x01 nonsense")
    (tmp_path / "mesh.stl").write_text("solid")
    fails(run("scan", tmp_path / "cloud.ply", "-o", out), "faces")
    fails(run("scan", tmp_path / "text.obj", "-o", out), "text.obj")
    fails(run("scan", tmp_path / "mesh.stl", "-o", out), ".stl")
    fails(run("scan", tmp_path, "-o", out))
    fails(run("scan", scan_file, "-o", out), "Scan")
    assert not out.exists()


def test_repair_goes_on_with_the_largest_part(tmp_path):
    path, out = tmp_path / "two.ply", tmp_path / "s.npz"
    big = body()
    small = trimesh.creation.icosphere(subdivisions=1)
    small.apply_translation([9, 0, 0])
    trimesh.util.concatenate([big, small]).export(path)
    fails(run("scan", path, "-o", out, *SMALL), "--repair")
    assert run("scan", path, "-o", out, *SMALL, "--repair").exit_code == 0
    assert Scan.load(out).points[:, 0].max() < 5


@pytest.mark.parametrize("value", ["0", "-0.5", "1.5", "nan"])
def test_thresholds_outside_the_range_are_refused(value, mesh_file, tmp_path):
    out = tmp_path / "s.npz"
    fails(run("scan", mesh_file, "-o", out, "-t", value), "threshold", value)
    assert not out.exists()


def test_impossible_settings_are_refused(mesh_file, tmp_path):
    out = tmp_path / "s.npz"
    fails(run("scan", mesh_file, "-o", out, "--views", "0"), "views")
    fails(run("scan", mesh_file, "-o", out, "--views", "some"), "views")
    fails(run("scan", mesh_file, "-o", out, "--set", "colour=1"), "colour")
    fails(run("scan", mesh_file, "-o", out, "--set", "noise"), "NAME=VALUE", status=2)
    fails(run("scan", mesh_file, "-o", out, *SMALL, "--set", "baseline=0"), "baseline")
    fails(run("scan", mesh_file, "-o", out, *SMALL, "-t", "1.0"), "acquired")  # no view sees anything
    assert not out.exists()


def test_outputs_that_cannot_be_written_are_refused_before_any_work(mesh_file, tmp_path):
    fails(run("scan", mesh_file, "-o", mesh_file / "sub" / "s.npz"), "folder")
    fails(run("scan", mesh_file, "-o", tmp_path / "s.txt"), ".npz or .ply")
    fails(run("scan", mesh_file, "-o", tmp_path), ".npz")
    fails(run("scan", mesh_file, "-o", tmp_path / "s.npz", "--preview", tmp_path / "p.doc"), ".png")
    fails(run("run", "quick", "-o", mesh_file), "folder")
    assert list(tmp_path.iterdir()) == []


# ---------------------------------------------------------------------------- match, symmetry

FAST = ["--modes", "30", "--points", "400"]


def load_map(path):
    return load_record(path, "Correspondence")


def test_a_scan_matched_to_itself_lands_on_itself(scan_file, tmp_path):
    out = tmp_path / "map.npz"
    result = run("match", scan_file, scan_file, "-o", out, *FAST)
    assert result.exit_code == 0, result.output
    arrays, meta = load_map(out)
    scan = Scan.load(scan_file)
    assert np.array_equal(arrays["source_points"], scan.points)
    assert np.array_equal(arrays["target_points"], scan.points)
    image = arrays["source_to_target"]
    assert image.shape == arrays["confidence"].shape == (600,)
    assert ((image >= 0) & (image < 600)).all()
    assert ((arrays["confidence"] >= 0) & (arrays["confidence"] <= 1)).all()
    assert arrays["landmarks"].shape[1] == 2
    gap = np.linalg.norm(scan.points - scan.points[image], axis=1)
    assert np.median(gap) < 0.1 * np.ptp(scan.points, axis=0).max()
    assert meta["method"] == "medial"


def test_clouds_of_every_kind_are_read(scan_file, mesh_file, tmp_path):
    from reports.cli.cloud_files import read_cloud

    scan = Scan.load(scan_file)
    with_normals = np.hstack([scan.points, scan.normals])
    np.savetxt(tmp_path / "c.xyz", with_normals, header="x y z nx ny nz")
    np.savetxt(tmp_path / "comma.xyz", with_normals, delimiter=",")
    scan.save(tmp_path / "c.ply")
    lines = [f"v {x} {y} {z}\nvn {a} {b} {c}" for x, y, z, a, b, c in with_normals]
    (tmp_path / "c.obj").write_text("\n".join(lines))
    for name in ("c.xyz", "comma.xyz", "c.ply", "c.obj"):
        cloud = read_cloud(tmp_path / name, 10_000)
        assert np.allclose(cloud.points, scan.points, atol=1e-6), name
        assert np.allclose(cloud.scan.normals, scan.normals, atol=1e-6), name
        assert np.array_equal(cloud.kept, np.arange(600))
    sampled = read_cloud(mesh_file, 500)
    assert len(sampled.points) == len(sampled.scan) == 500
    x, y, z = sampled.points.T  # back to the sphere that the body is made of
    radius = np.hypot(np.hypot((x - 0.25 * y**2 - 0.1 * y) / 0.5, y / 1.5), z / (0.4 + 0.16 * np.tanh(y)))
    assert np.abs(radius - 1).max() < 0.02


def test_missing_normals_are_estimated_and_mentioned(scan_file, tmp_path):
    from reports.cli.cloud_files import read_cloud

    scan = Scan.load(scan_file)
    np.savetxt(tmp_path / "bare.xyz", scan.points)
    result = run("match", tmp_path / "bare.xyz", scan_file, "-o", tmp_path / "m.npz", *FAST)
    assert result.exit_code == 0, result.output
    assert "normals" in result.stderr
    estimated = read_cloud(tmp_path / "bare.xyz", 10_000).scan.normals
    assert np.median(np.einsum("nd,nd->n", estimated, scan.normals)) > 0.9


def test_points_that_were_not_matched_follow_their_nearest_neighbour(scan_file, tmp_path):
    out = tmp_path / "m.npz"
    assert run("match", scan_file, scan_file, "-o", out, "--modes", 30, "--points", 300).exit_code == 0
    image = load_map(out)[0]["source_to_target"]
    assert len(image) == 600
    assert len(np.unique(image)) <= 300


def test_clouds_that_cannot_be_matched_are_refused(scan_file, tmp_path):
    out = tmp_path / "m.npz"
    few, nan, words, wide = (tmp_path / f"{name}.xyz" for name in ("few", "nan", "words", "wide"))
    directions = np.random.default_rng(0).normal(size=(20, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    np.savetxt(few, np.hstack([directions, directions]))
    np.savetxt(nan, np.full((30, 6), np.nan))
    words.write_text("a b c\n")
    np.savetxt(wide, np.ones((30, 4)))
    fails(run("match", few, scan_file, "-o", out), "20 points")  # fewer than modes
    fails(run("match", nan, scan_file, "-o", out), "NaN")
    fails(run("match", words, scan_file, "-o", out), "words.xyz")
    fails(run("match", wide, scan_file, "-o", out), "(30, 4)")
    fails(run("match", tmp_path / "no.npz", scan_file, "-o", out), "does not exist")
    fails(run("match", scan_file, scan_file, "-o", out, "--method", "medail"), "medail", "medial")
    fails(run("match", scan_file, scan_file, "-o", out, "--set", "colour=1"), "colour")
    fails(run("match", scan_file, scan_file, "-o", out, "--set", "colour"), "NAME=VALUE", status=2)
    fails(run("match", scan_file, scan_file, "-o", out, "--method", "truth-landmarks"), "ground truth")
    fails(run("match", scan_file, scan_file, "-o", tmp_path / "m.txt"), ".npz")
    fails(run("match", scan_file, scan_file, "-o", out, "--device", "gpu"), "'gpu'", "cuda")
    fails(run("symmetry", scan_file, "-o", out, "--device", "gpu"), "'gpu'", "cuda")
    (tmp_path / "cut.npz").write_bytes(scan_file.read_bytes()[:1000])
    fails(run("match", tmp_path / "cut.npz", scan_file, "-o", out), "cut.npz")
    assert not out.exists()


def test_symmetry_maps_a_cloud_to_itself_and_draws_it(scan_file, tmp_path):
    out, picture = tmp_path / "map.npz", tmp_path / "map.png"
    result = run("symmetry", scan_file, "-o", out, *FAST, "--picture", picture)
    assert result.exit_code == 0, result.output
    arrays, meta = load_map(out)
    assert np.array_equal(arrays["source_points"], arrays["target_points"])
    image = arrays["source_to_target"]
    assert image.shape == (600,)
    assert ((image >= -1) & (image < 600)).all()
    assert meta["method"] == "symmetry"
    assert picture.read_bytes()[:4] == b"\x89PNG"
    fails(run("symmetry", scan_file, "-o", out, "--picture", tmp_path / "p.gif"), ".png or .pdf")


# ---------------------------------------------------------------------------- run, report, compare


def test_experiments_that_cannot_run_are_refused(tmp_path):
    out = tmp_path / "out"
    unknown = tmp_path / "unknown.toml"
    unknown.write_text('name = "x"\nseads = [1]\n[[dataset]]\nname = "human"\n')
    broken = tmp_path / "broken.toml"
    broken.write_text("name = \n")
    fails(run("run", "quik", "-o", out), "quik", "quick")
    fails(run("run", unknown, "-o", out), "seads", "seeds")
    fails(run("run", broken, "-o", out), "broken.toml")
    fails(run("run", tmp_path / "none.toml", "-o", out), "none.toml")
    fails(run("run", "quick", "-o", out, "--dataset", "humen", "--dry-run"), "humen")
    assert not out.exists()


def test_dry_runs_write_nothing(tmp_path):
    result = run("run", "quick", "-o", tmp_path / "out", "--dry-run")
    assert result.exit_code == 0, result.output
    assert "human" in result.output
    assert list(tmp_path.iterdir()) == []


def test_folders_without_results_are_refused(tmp_path):
    for command in ("report", "compare"):
        fails(run(command, tmp_path / "none"), "none")
        fails(run(command, tmp_path), "no results")
    fails(run("merge", tmp_path / "none", "-o", tmp_path / "joint"), "none")
    fails(run("merge", "-o", tmp_path / "joint"), "DIR", status=2)
    assert list(tmp_path.iterdir()) == []


SWEEP = """
name = "tiny"
seeds = [0]
evaluated = 50
[[dataset]]
name = "{folder}"
[scan]
views = 4
points = 300
scanner = {{ resolution = [60, 60], stripes = 80 }}
[operators]
modes = 20
[stability]
operators = ["heat"]
sweep = {{ threshold = [0.3] }}
[matching]
[[matching.regime]]
name = "easy"
threshold = 0.3
[[method]]
name = "heat"
label = "heat kernel"
"""


def test_a_run_ends_with_the_leaderboard_and_the_report_and_goes_on_from_what_is_stored(tmp_path):
    poses = tmp_path / "club"
    poses.mkdir()
    straight, bent = body(), body()
    bent.vertices[:, 0] += 0.1 * bent.vertices[:, 1] ** 2
    straight.export(poses / "rest.ply")
    bent.export(poses / "bent.ply")
    config, out = tmp_path / "tiny.toml", tmp_path / "out"
    config.write_text(SWEEP.format(folder=poses))
    result = run("run", config, "-o", out, "--jobs", "1")
    assert result.exit_code == 0, result.output
    assert "club, easy" in result.stdout
    assert "heat kernel" in result.stdout
    page = out.resolve() / "report" / "index.html"
    assert result.stdout.splitlines()[-1] == str(page)
    assert page.is_file()
    dry = run("run", config, "-o", out, "--dry-run")
    assert "nothing to run" in dry.stdout
    before = (out / "table.csv").read_bytes()
    again = run("run", config, "-o", out, "--no-report", "-q")
    assert again.exit_code == 0
    assert (out / "table.csv").read_bytes() == before
    joint = run("merge", out, "-o", tmp_path / "joint")
    assert joint.exit_code == 0, joint.output
    assert run("compare", tmp_path / "joint").exit_code == 0
