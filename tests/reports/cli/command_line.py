"""What the tests of the command line share: running it, a mesh, a scan of it."""

import numpy as np
import trimesh
from click.testing import CliRunner

from reports.cli.main import cli

SIZE = ["--modes", "30", "--points", "400"]
LITTLE = ("finalists=2", "restarts=4", "partners=2", "nodes=40", "fine_nodes=80", "samples=200")
LITTLE += ("recombine=false", "both_ways=false", "rigid_starts=false")
FAST = SIZE + [word for setting in LITTLE for word in ("--set", setting)]
"""A third of the time: most tests ask what goes in and out, not how well it is matched."""
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
