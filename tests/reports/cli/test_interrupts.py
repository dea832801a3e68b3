"""Ctrl-C on commands: one line, its exit status, nothing left behind, no crash."""

import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from reports.cli.console import Command
from reports.cli.main import cli
from tests.reports.cli.command_line import run

needs_signals = pytest.mark.skipif(os.name != "posix", reason="sends Ctrl-C to one process")


@needs_signals
def test_a_match_that_is_interrupted_ends_with_one_line(tmp_path):
    random = np.random.default_rng(0)
    for name in ("a.xyz", "b.xyz"):
        points = random.standard_normal((6000, 3))
        points /= np.linalg.norm(points, axis=1, keepdims=True)
        np.savetxt(tmp_path / name, np.hstack([points * [1, 2, 3], points]))
    command = [sys.executable, "-m", "reports.cli.main", "match", "a.xyz", "b.xyz", "-o", "m.npz"]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(p for p in sys.path if p), "TERM": "dumb"}
    with subprocess.Popen(
        command, cwd=tmp_path, env=environment, stderr=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as process:
        time.sleep(2.5)  # within the operators
        process.send_signal(signal.SIGINT)
        _, errors = process.communicate(timeout=60)
    assert process.returncode == 130, errors
    assert errors.rstrip().endswith("medialbench: interrupted")
    assert "Traceback" not in errors
    assert sorted(p.name for p in tmp_path.iterdir()) == ["a.xyz", "b.xyz"]


@needs_signals
@pytest.mark.parametrize("module", ["llvmlite.binding", "importlib._bootstrap_external"])
def test_ctrl_c_waits_while_modules_and_machine_code_are_loaded(module):
    """What is raised within these calls is lost or fatal: it is raised after that."""
    code = f"""
import signal, time, types
from reports.cli import main

def loading(order):
    signal.raise_signal(signal.SIGINT)
    order.append("loaded")

load = types.FunctionType(loading.__code__, {{"__name__": {module!r}, "signal": signal}})
signal.signal(signal.SIGINT, main.Interrupt())
order = []
try:
    load(order)
    order.append("after")
    time.sleep(30)
except KeyboardInterrupt:
    order.append("interrupted")
try:
    signal.raise_signal(signal.SIGINT)
except KeyboardInterrupt:
    order.append("at once")
print(order)
"""
    found = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True, timeout=60
    )
    assert found.stdout.strip() == "['loaded', 'after', 'interrupted', 'at once']"


@needs_signals
def test_an_import_that_does_not_end_is_interrupted(tmp_path):
    (tmp_path / "endless.py").write_text(
        "import os, signal, time\nos.kill(os.getpid(), signal.SIGINT)\ntime.sleep(60)\n"
    )
    code = (
        "import signal, sys; from reports.cli import main; main.PATIENCE = 0.3;"
        "signal.signal(signal.SIGINT, main.Interrupt()); sys.path.insert(0, sys.argv[1]); import endless"
    )
    command = [sys.executable, "-c", code, str(tmp_path)]
    found = subprocess.run(command, capture_output=True, text=True, timeout=40, check=False)
    assert found.stderr.rstrip().endswith("KeyboardInterrupt")


@needs_signals
@pytest.mark.parametrize("closed", ["1>&-", "2>&-", "2>/dev/full"])
def test_ctrl_c_where_nothing_can_be_printed(closed, tmp_path):
    code = (
        "import os, signal, sys; from reports.cli.main import cli, main; sys.argv[1:] = ['doctor'];"
        "cli.get_command = lambda ctx, name: os.kill(os.getpid(), signal.SIGINT); main()"
    )
    script = f'exec {sys.executable} -c "{code}" {closed}'
    assert subprocess.run(["bash", "-c", script], timeout=60, check=False).returncode == 130


def test_ctrl_c_just_when_a_kernel_returns(monkeypatch):
    """Python makes a SystemError of what is set when a compiled function returns a result."""

    def work(quiet):
        raise SystemError("returned a result with an exception set") from KeyboardInterrupt()

    monkeypatch.setattr(cli, "get_command", lambda ctx, name: Command("doctor", callback=work))
    result = run("doctor")
    assert result.exit_code == 130
    assert "interrupted" in result.stderr
    assert "SystemError" not in result.stderr
