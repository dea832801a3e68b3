"""Maps of clouds in files."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

from datasets_gen.records import InputError, load_record
from medial import Matching
from medial.validation import unit_normals
from scanner_sim import Scan
from tests.reports.cli.command_line import FAST, SIZE, fails, run

PLY = (
    "ply\nformat ascii 1.0\nelement vertex 2\n"
    "property float x\nproperty float y\nproperty float z\nend_header\n"
)
"""The header of a cloud of two points, seven lines."""


def load_map(path):
    return load_record(path, "Matching")


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
    assert arrays["landmarks"].shape[1] == 2
    gap = np.linalg.norm(scan.points - scan.points[image], axis=1)
    spacing = cKDTree(scan.points).query(scan.points, k=2)[0][:, 1].mean()
    assert gap.mean() < spacing
    assert np.median(arrays["confidence"]) > 0.9
    assert meta["about"]["method"] == "medial"


@pytest.mark.parametrize(
    ("points", "said"),
    [("400", "Matched 400 points; extended to all 600; confident on "), ("600", "Matched all 600 points; ")],
)
def test_the_summary_says_how_many_points_were_matched_and_how_surely(scan_file, tmp_path, points, said):
    result = run("match", scan_file, scan_file, "-o", tmp_path / "m.npz", "--modes", "30", "--points", points)
    lines = result.stderr.strip().splitlines()
    (line,) = [each for each in lines if each.startswith(said)]
    likely = Matching.load(tmp_path / "m.npz").probability
    told = "It is open" in result.stderr or np.isnan(likely)
    probability = "" if told else f"; probability of the map {likely:.2f}"
    assert f" % (confidence of at least 0.5){probability}; written to " in line
    assert lines[-1].startswith("to look at it: --picture FILE, --view FILE, or medialbench.plot(")


def test_clouds_of_every_kind_are_read(scan_file, mesh_file, tmp_path):
    from reports.cli.cloud_files import read_thinned

    scan = Scan.load(scan_file)
    with_normals = np.hstack([scan.points, scan.normals])
    np.savetxt(tmp_path / "c.xyz", with_normals, header="x y z nx ny nz")
    np.savetxt(tmp_path / "comma.xyz", with_normals, delimiter=",")
    scan.save(tmp_path / "c.ply")
    lines = [f"v {x} {y} {z}\nvn {a} {b} {c}" for x, y, z, a, b, c in with_normals]
    (tmp_path / "c.obj").write_text("\n".join(lines))
    for name in ("c.xyz", "comma.xyz", "c.ply", "c.obj"):
        cloud = read_thinned(tmp_path / name, 10_000)
        assert np.allclose(cloud.points, scan.points, atol=1e-6), name
        assert np.allclose(cloud.scan.normals, scan.normals, atol=1e-6), name
        assert np.array_equal(cloud.kept, np.arange(600))
    sampled = read_thinned(mesh_file, 500)
    assert len(sampled.points) == len(sampled.scan) == 500
    x, y, z = sampled.points.T  # back to the sphere that the body is made of
    radius = np.hypot(np.hypot((x - 0.25 * y**2 - 0.1 * y) / 0.5, y / 1.5), z / (0.4 + 0.16 * np.tanh(y)))
    assert np.abs(radius - 1).max() < 0.02


def test_missing_normals_are_estimated_and_mentioned(scan_file, tmp_path):
    from reports.cli.cloud_files import read_thinned

    scan = Scan.load(scan_file)
    np.savetxt(tmp_path / "bare.xyz", scan.points)
    result = run("match", tmp_path / "bare.xyz", scan_file, "-o", tmp_path / "m.npz", *FAST)
    assert result.exit_code == 0, result.output
    assert "normals" in result.stderr
    estimated = read_thinned(tmp_path / "bare.xyz", 10_000).scan.normals
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
    directions = np.random.default_rng(0).normal(size=(5, 3))
    directions /= np.linalg.norm(directions, axis=1, keepdims=True)
    np.savetxt(few, np.hstack([directions, directions]))
    repeated = tmp_path / "repeated.xyz"
    np.savetxt(repeated, np.tile(np.hstack([directions, directions]), (9, 1)))
    np.savetxt(nan, np.full((30, 6), np.nan))
    words.write_text("a b c\n")
    np.savetxt(wide, np.ones((30, 5)))
    fails(run("match", few, scan_file, "-o", out), f"{str(few)!r} has 5 points: too few")
    fails(
        run("match", scan_file, repeated, "-o", out),
        f"the points of {str(repeated)!r} lie at 5 places: too few",
    )
    fails(run("match", nan, scan_file, "-o", out), "NaN")
    fails(run("match", words, scan_file, "-o", out), "words.xyz")
    fails(run("match", wide, scan_file, "-o", out), "line 1, has 5 columns")
    fails(run("match", tmp_path / "no.npz", scan_file, "-o", out), "does not exist")
    fails(run("match", scan_file, scan_file, "-o", out, "--method", "medail"), "medail", "medial")
    fails(run("match", scan_file, scan_file, "-o", out, "--set", "colour=1"), "colour")
    fails(run("match", scan_file, scan_file, "-o", out, "--set", "colour"), "NAME=VALUE", status=2)
    fails(run("match", scan_file, scan_file, "-o", out, "--method", "truth-landmarks"), "ground truth")
    fails(run("match", scan_file, scan_file, "-o", tmp_path / "m.dat"), ".npz", ".vts")
    fails(run("match", scan_file, scan_file, "-o", out, "--view", tmp_path / "m.png"), ".html")
    fails(run("match", scan_file, scan_file, "-o", out, "--device", "gpu"), "'gpu'", "cuda")
    fails(run("symmetry", scan_file, "-o", out, "--device", "gpu"), "'gpu'", "cuda")
    fails(run("match", scan_file, scan_file, "-o", out, "--departures", "some"), "'some'", "'none'")
    settings = 'settings={departures="none"}'
    fails(run("match", scan_file, scan_file, "-o", out, "--set", settings), "--departures")
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
    assert meta["about"]["method"] == "symmetry"
    assert picture.read_bytes()[:4] == b"\x89PNG"
    fails(run("symmetry", scan_file, "-o", out, "--picture", tmp_path / "p.gif"), ".png or .pdf")


def test_departures_reach_operator_and_matcher(scan_file, tmp_path):
    out = tmp_path / "map.npz"
    for command in (("match", scan_file, scan_file), ("symmetry", scan_file)):
        result = run(*command, "-o", out, *SIZE, "--departures", "none")
        assert result.exit_code == 0, result.output
        config = load_map(out)[1]["config"]
        assert config["selection"] == "cost"
        assert not any(config["departures"].values())
    fails(run("match", out, scan_file, "-o", tmp_path / "again.npz"), "holds a Matching", "give a scan")


def test_settings_of_the_matcher_stand_by_themselves(scan_file, tmp_path):
    out = tmp_path / "map.npz"
    given = ["--set", "refine=spectral", "--set", "evidence=visibility,strain", "--set", "finalists=2"]
    for command in (("match", scan_file, scan_file), ("symmetry", scan_file)):
        result = run(*command, "-o", out, *FAST, *given)
        assert result.exit_code == 0, result.output
        config = load_map(out)[1]["config"]
        assert (config["refine"], config["finalists"]) == ("spectral", 2)
        assert config["evidence"] == ["visibility", "strain"]
        fails(run(*command, "-o", out, "--set", "finalist=2"), "'finalist'; did you mean 'finalists'?")
        fails(run(*command, "-o", out, "--set", "refine=deformed"), "refine must be one of")


@pytest.mark.parametrize("count", [1, 20])
def test_stray_points_change_nothing_for_the_others(scan_file, tmp_path, count):
    scan = Scan.load(scan_file)
    columns = np.hstack([scan.points, scan.normals])
    away = np.random.default_rng(count).normal(size=(count, 6))
    away[:, :3] *= 1e4 * np.ptp(scan.points)
    np.savetxt(tmp_path / "clean.xyz", columns)
    np.savetxt(tmp_path / "strewn.xyz", np.concatenate([columns, away]))
    results = {}
    for name in ("clean", "strewn"):
        cloud, out = tmp_path / f"{name}.xyz", tmp_path / f"{name}.npz"
        done = run("match", cloud, cloud, "-o", out, *FAST)
        assert done.exit_code == 0, done.output
        results[name] = load_map(out)[0]
    assert f" {count} point" in done.stderr
    assert done.stderr.count("far from all others; not matched") == 1  # both are one file
    for key in ("source_to_target", "confidence"):
        assert np.array_equal(results["strewn"][key][:-count], results["clean"][key])
    assert (results["strewn"]["confidence"][-count:] == 0).all()


@pytest.mark.parametrize(
    ("name", "text", "said"),
    [
        ("a.xyz", "0 0 0\n1 2 3\n4 5\n", "line 3, has 2 columns, the first line 3"),
        ("b.xyz", "# x y z\n0 0 0\n1 x 3\n", "line 3, is no row of numbers"),
        ("c.xyz", "nan 0 0\n1 nan 3\n", "has no points: all 2 are NaN or infinite"),
        ("d.xyz", "0 0\n", "line 1, has 2 columns, which can mean several things; name the columns"),
        ("e.obj", "v 0 0 0\nv 1 0 0\nv 0 oops 0\nf 1 2 3\n", "line 3: 'oops' where a number should be"),
        ("g.ply", PLY + "0 0 0\n1 oops 0\n", "line 9: 'oops' where a number should be"),
        ("h.ply", PLY + "0 0 0\n1 0\n", "line 9: 2 numbers where 3 are needed"),
        ("i.ply", PLY + "nan 0 0\n1 nan 0\n", "has no points: all 2 are NaN or infinite"),
        ("j.ply", PLY + "0 0 0\n", "line 8 is the last: 1 rows of kind 'vertex' where 2 should be"),
        ("k.off", "OFF\n2 0 0\n0 0 0\n1 oops 0\n", "line 4: 'oops' where a number should be"),
        ("f.obj", "v 0 0 0\nv 1 0 0\nvn 0 0 1\nvn 0 0\n", "line 4: 2 numbers where three are needed"),
    ],
)
def test_files_that_cannot_be_read_are_told_with_the_line(tmp_path, name, text, said):
    file = tmp_path / name
    file.write_text(text)
    fails(run("match", file, file), said)


def test_normals_that_are_missing_without_a_file_are_told(scan_file):
    scan = Scan.load(scan_file)
    normals = scan.normals.copy()
    normals[7] = 0
    said = "has 1 normals that are zero or not finite, the first number 7; give unit outward normals"
    with pytest.raises(InputError, match=said):
        unit_normals(scan.points, normals)
