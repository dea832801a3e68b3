"""The command that installs an extra is one that works where it is said."""

from importlib.metadata import PackageNotFoundError

import pytest

from datasets_gen import extras


class Installed:
    """A distribution with this ``direct_url.json``."""

    def __init__(self, origin):
        self.origin = origin

    def read_text(self, name):
        assert name == "direct_url.json"
        return self.origin


@pytest.mark.parametrize(
    ("origin", "command"),
    [
        (None, "pip install 'medialbench[peers]'"),  # from an index
        ('{"url": "file:///a/medialbench.whl", "archive_info": {}}', "pip install 'medialbench[peers]'"),
        ('{"url": "file:///a", "dir_info": {}}', "pip install 'medialbench[peers]'"),
        ("no JSON", "pip install 'medialbench[peers]'"),
        ('{"url": "file:///a", "dir_info": {"editable": true}}', "pip install -e '.[peers]'"),
    ],
)
def test_an_editable_installation_is_a_checkout(monkeypatch, origin, command):
    monkeypatch.setattr(extras, "distribution", lambda name: Installed(origin))
    assert extras.pip_install("peers") == command


def test_what_is_not_installed_is_a_checkout(monkeypatch):
    def lacking(name):
        raise PackageNotFoundError(name)

    monkeypatch.setattr(extras, "distribution", lacking)
    assert extras.pip_install("exr") == "pip install -e '.[exr]'"


def test_methods_name_the_command(monkeypatch):
    from evaluation.methods import catalogue

    monkeypatch.setattr(extras, "distribution", lambda name: Installed(None))
    monkeypatch.setattr(catalogue, "find_spec", lambda module: None)
    assert catalogue.missing("cpd").endswith(": pip install 'medialbench[peers]'")
