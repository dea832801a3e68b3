"""Listing and writing data sets."""

import json

from tests.datasets_gen.collections.gltf_files import animate, turn, two_bones
from tests.datasets_gen.collections.test_frame_sequence import frames
from tests.datasets_gen.collections.test_shrec_partial import written
from tests.reports.cli.command_line import FAST, body, fails, run


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


def test_the_list_says_from_where_under_which_terms_and_what_is_held_out():
    lines = run("datasets").stdout.splitlines()
    hand = next(k for k, line in enumerate(lines) if line.startswith("hand "))
    assert lines[hand] == "hand  a right hand with its wrist (built in, MIT; held out)"
    assert lines[hand + 1].split(", ")[:2] == ["    rest", "relaxed"]
    assert any(line.startswith("torus ") and line.endswith("(built in, MIT)") for line in lines)


def test_a_body_is_shown_with_the_lengths_of_its_edges_and_drawn(tmp_path):
    shown = run("datasets", "torus", "--set", 'poses=["round", "stretched"]')
    lines = [line for line in shown.output.splitlines() if line.startswith("torus/")]
    assert lines[0] == "torus/round  edges x 1.00 to 1.00, 99 % of them 1.00 to 1.00"
    assert lines[1].startswith("torus/stretched  edges x 0.88 to 1.30")
    picture = tmp_path / "torus.png"
    drawn = run("datasets", "torus", "--set", 'poses=["round"]', "--picture", picture)
    assert drawn.exit_code == 0, drawn.output
    assert picture.read_bytes()[:4] == b"\x89PNG"


def test_what_is_written_says_how_it_was_made(tmp_path):
    out = tmp_path / "out"
    result = run("datasets", "torus", "--seed", 2, "--set", "mesh_noise=0.2", "-o", out)
    assert result.exit_code == 0, result.output
    manifest = json.loads((out / "manifest.json").read_text())
    assert {key: manifest[key] for key in ("licence", "seed", "mesh_noise", "held_out", "subject")} == {
        "licence": "MIT", "seed": 2, "mesh_noise": 0.2, "held_out": False, "subject": "torus-2-noise0.2",
    }  # fmt: skip


def test_options_that_a_data_set_does_not_have_are_told():
    fails(run("datasets", "torus", "--set", "size=2"), "no option 'size'; it has seed, poses, subjects")
    fails(run("datasets", "--set", "seed=2"), "need the NAME", status=2)
    fails(run("datasets", "torus", "--picture", "x.jpg"), "ends in .png")


def test_the_list_has_the_sets_of_the_field_and_where_they_come_from():
    lines = run("datasets").stdout.splitlines()
    tosca = next(k for k, line in enumerate(lines) if line.startswith("TOSCA "))
    assert "cat0.vert + cat0.tri" in lines[tosca]
    assert "http://tosca.cs.technion.ac.il/book/resources_data.html (terms: " in lines[tosca + 1]
    assert any(line.startswith("glTF ") for line in lines)
    assert any("nothing is downloaded" in line for line in lines)


def test_a_set_of_the_field_is_shown_with_what_loading_found(tmp_path):
    written(tmp_path)
    shown = run("datasets", tmp_path, "--set", "subject=cat")
    assert shown.exit_code == 0, shown.output
    line = next(line for line in shown.output.splitlines() if line.startswith("cat/cuts-1 "))
    assert line.endswith("vertices of its own, placed on 'null'")
    assert "cat/null: 162 vertices, 320 faces, diagonal" in shown.output
    fails(run("datasets", tmp_path), "several subjects: cat, dog; choose one")
    fails(run("datasets", tmp_path, "--set", "subject=cat", "-o", tmp_path / "out"), "a mesh of its own")


def test_a_character_is_shown_drawn_and_written_as_poses(tmp_path):
    writer, _, _ = two_bones()
    animate(writer, "bend", times=[0.0, 1.0], values=[turn(0, 0), turn(0, 60)])
    path = writer.write_glb(tmp_path / "tube.glb")
    shown = run("datasets", path, "--set", "frames=2")
    assert shown.exit_code == 0, shown.output
    for words in ("tube/bend-2  edges x", "as it is used: closed, one piece, genus 0, wound consistently"):
        assert words in shown.output
    picture = tmp_path / "tube.png"
    assert run("datasets", path, "--set", "frames=2", "--picture", picture).exit_code == 0
    assert picture.read_bytes()[:4] == b"\x89PNG"
    assert run("datasets", path, "--set", "frames=2", "-o", tmp_path / "out").exit_code == 0
    assert run("datasets", tmp_path / "out", "-q").stdout.split() == [
        "tube/rest",
        "tube/bend-1",
        "tube/bend-2",
    ]
    planned = run("run", "quick", "--dataset", path, "--poses", "rest,bend-2", "--dry-run")
    assert planned.exit_code == 0, planned.output
    assert "tube: rest, bend-2" in planned.output


def test_frames_without_truth_are_shown_and_not_run(tmp_path):
    folder = frames(tmp_path / "jump")
    shown = run("datasets", folder)
    assert shown.exit_code == 0, shown.output
    assert "jump/frame_10  162 vertices of its own" in shown.output
    assert "nothing can be scored" in shown.output
    assert run("datasets", folder, "--picture", tmp_path / "jump.png").exit_code == 0
    refused = run("datasets", folder, "-o", tmp_path / "out")
    assert refused.exit_code == 1
    assert "'jump' has a mesh of its own" in refused.stderr
    result = run("run", "quick", "--dataset", folder, "-o", tmp_path / "results", "-q")
    fails(result, "'jump' has no ground truth", "medialbench match A B")
    assert not (tmp_path / "results").exists()
    pair = [folder / "frame_10.obj", folder / "frame_11.obj"]
    matched = run("match", *pair, "-o", tmp_path / "map.npz", "--picture", tmp_path / "map.png", *FAST)
    assert matched.exit_code == 0, matched.output
    assert (tmp_path / "map.png").read_bytes()[:4] == b"\x89PNG"
