"""A mesh, a scan of it, and an empty current folder."""

import pytest

from tests.reports.cli.command_line import SMALL, body, run


@pytest.fixture(scope="session")
def mesh_file(tmp_path_factory):
    path = tmp_path_factory.mktemp("mesh") / "body.ply"
    body().export(path)
    return path


@pytest.fixture(scope="session")
def scan_file(mesh_file, tmp_path_factory):
    path = tmp_path_factory.mktemp("scan") / "body.npz"
    result = run("scan", mesh_file, "-o", path, *SMALL, "-t", "0.3", "--points", 600)
    assert result.exit_code == 0, result.output
    return path


@pytest.fixture
def here(tmp_path, monkeypatch):
    """An empty current folder."""
    monkeypatch.chdir(tmp_path)
    return tmp_path
