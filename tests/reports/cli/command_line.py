"""What the tests of the command line share: running it, a mesh, a scan of it."""

import numpy as np
import trimesh
from click.testing import CliRunner

from reports.cli.main import cli
from tests.little_matching import AS_OPTIONS

SIZE = ["--modes", "30", "--points", "400"]
FAST = SIZE + AS_OPTIONS
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
