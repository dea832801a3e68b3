"""No name from data leaves its folder, and no two names share a file."""

from pathlib import Path

import pytest

from datasets_gen import InputError
from datasets_gen.paths import LONGEST, distinct_names, inside, safe_name

HOSTILE = [
    "../../../esc", "/etc/passwd", "..", ".", "", ".hidden", "a/b", "a\\b", "C:\\x", "CON", "nul.txt", "-rf",
    "x.", "x ", "a\nb", "a\0b", "$(id)", "<b>", "a|b", "%2e%2e", "a=2Fb", "~", "\ud800",
    "x" * 400, "x" * 401, "日本" * 100,
]  # fmt: skip


@pytest.mark.parametrize("text", HOSTILE)
def test_any_text_is_one_part_of_a_path(text, tmp_path):
    name = safe_name(text)
    assert Path(name).name == name
    assert not name.startswith((".", "-"))
    assert len(name.encode()) <= LONGEST
    assert not set("/\\\0\n:|<>%$") & set(name)
    path = inside(tmp_path, f"{name}.ply")
    path.write_text("")
    assert path.resolve().parent == tmp_path.resolve()


def test_other_texts_get_other_names():
    assert len({safe_name(text) for text in HOSTILE}) == len(HOSTILE)


@pytest.mark.parametrize("name", ["walk", "t_pose", "pose 2", "a+b", "Läufer", "human-3", "tau 0.3, views 6"])
def test_ordinary_names_stay(name):
    assert safe_name(name) == name


def test_names_in_one_case_are_told_apart():
    assert distinct_names(["walk", "a/b"], "pose") == {"walk": "walk", "a/b": "a=2Fb"}
    with pytest.raises(InputError, match="poses 'walk' and 'Walk' would be one file"):
        distinct_names(["walk", "Walk"], "pose")


@pytest.mark.parametrize("name", ["../x", "/etc/passwd", "a/../../x", ".", "", "a/..", "x\0y"])
def test_names_that_leave_the_folder_are_refused(name, tmp_path):
    with pytest.raises(InputError, match="file") as error:
        inside(tmp_path, name)
    assert "\n" not in str(error.value)


def test_links_that_leave_the_folder_are_refused(tmp_path):
    home, away = tmp_path / "home", tmp_path / "away"
    home.mkdir()
    away.mkdir()
    (away / "x").write_text("")
    (home / "link").symlink_to(away / "x")
    (home / "folder").symlink_to(away)
    (home / "loop").symlink_to(home / "loop")
    (home / "real").write_text("")
    (home / "within").symlink_to(home / "real")
    for name in ("link", "folder/x"):
        with pytest.raises(InputError, match="lies outside"):
            inside(home, name)
    for name in ("real", "within", "sub/new"):
        assert inside(home, name) == home / name
