import pytest

from datasets_gen import InputError
from datasets_gen.collections.wheel_files import Wheel
from tests.datasets_gen.collections.wheels import install

WHEEL = Wheel(
    "zoo_of_tests", "zoo-of-tests", "1.2", "Apache-2.0", ("zoo_of_tests-*.dist-info/licenses/*",), "pip it"
)


def test_what_is_not_installed_is_told_with_the_command():
    assert WHEEL.missing() == "zoo_of_tests is missing: pip it"
    with pytest.raises(InputError, match=r"^zoo_of_tests is missing: pip it$"):
        WHEEL.folder()


def test_the_folder_is_found_without_an_import(tmp_path, monkeypatch):
    package = install(monkeypatch, tmp_path, WHEEL)
    (package / "__init__.py").write_text("raise RuntimeError('imported')", encoding="utf-8")
    assert WHEEL.missing() is None
    assert WHEEL.folder() == package


def test_another_version_is_refused(tmp_path, monkeypatch):
    install(monkeypatch, tmp_path, WHEEL, version="1.3")
    with pytest.raises(InputError, match=r"zoo-of-tests is 1\.3, not 1\.2, and its files differ: pip it"):
        WHEEL.folder()


def test_other_packages_that_are_needed_are_named(tmp_path, monkeypatch):
    install(monkeypatch, tmp_path, WHEEL)
    wheel = Wheel("zoo_of_tests", "zoo-of-tests", "1.2", "", (), "pip it", needs=("numpy", "no_such_package"))
    assert wheel.missing() == "no_such_package is missing: pip it"


def test_the_terms_lie_beside_the_cache(tmp_path, monkeypatch):
    install(monkeypatch, tmp_path, WHEEL)
    path = WHEEL.write_terms()
    assert path == tmp_path / "cache" / "zoo-of-tests-1.2.licence.txt"
    text = path.read_text(encoding="utf-8")
    assert text.startswith("files of the package zoo-of-tests 1.2\nApache-2.0\n")
    assert text.endswith("licenses/LICENSE\nYou may.\n")
