"""Listing and writing data sets."""

import json

from tests.reports.cli.command_line import body, fails, run


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
