"""TOML and JSON as people write them: one kind of error."""

import pytest

from datasets_gen import InputError
from datasets_gen.parsing import parsed_json, parsed_toml, read_note


@pytest.mark.parametrize("content", ["a = 1\n", b"a = 1\n"])
def test_toml_is_read(content):
    assert parsed_toml(content, "file") == {"a": 1}


@pytest.mark.parametrize("content", ['{"a": 1}', b'{"a": 1}'])
def test_json_is_read(content):
    assert parsed_json(content, "file") == {"a": 1}


@pytest.mark.parametrize("content", [b"\xff", b"a = ", b"a = " + b"[" * 100_000, "a = " + "9" * 5000])
def test_what_is_no_toml_is_one_line(content):
    with pytest.raises(InputError, match=r"^'x\.toml' is not valid TOML: [^\n]+$"):
        parsed_toml(content, "'x.toml'")


@pytest.mark.parametrize("content", [b"\xff", b"{", b"[" * 100_000, "9" * 5000])
def test_what_is_no_json_is_one_line(content):
    with pytest.raises(InputError, match=r"^'x\.json' is not readable JSON \([^\n]+\)"):
        parsed_json(content, "'x.json'")


def test_a_note_is_read(tmp_path):
    path = tmp_path / "note.json"
    path.write_text('{"run": "a", "attempt": 2, "library": null}')
    expected = {"run": "a", "attempt": 2, "library": None}
    assert read_note(path, run=str, attempt=int, library=str | None) == expected


@pytest.mark.parametrize(
    "content",
    [None, b"", b"{", b"\xff", b"[" * 100_000, b"[]", b"{}", b'{"run": 1, "attempt": 2}', b'{"run": "a"}'],
)
def test_a_note_that_is_not_as_it_was_written_is_none(tmp_path, content):
    path = tmp_path / "note.json"
    if content is not None:
        path.write_bytes(content)
    assert read_note(path, run=str, attempt=int) is None
