"""A run that is killed in the middle and goes on ends with the same bytes as one that was left alone."""

import os
import signal
import subprocess
import sys
import time

import pytest

from evaluation.generation import generate, read_shards


def waited(condition, seconds):
    end = time.monotonic() + seconds
    while not condition() and time.monotonic() < end:
        time.sleep(0.02)
    return condition()


@pytest.mark.slow
def test_killed_in_the_middle(tiny, tmp_path, scheduler):
    config = tiny()
    (tmp_path / "tiny.toml").write_text(config.to_toml())
    folder, count = tmp_path / "killed", 120
    command = [sys.executable, "-m", "reports.cli.main", "generate", "tiny.toml", "-n", str(count)]
    command += ["-o", str(folder), "--shard-size", "5", "--jobs", "1", "--quiet"]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)}
    process = subprocess.Popen(command, cwd=tmp_path, env=environment)
    try:
        assert waited(lambda: len(list(folder.glob("train-*.tar"))) >= 3, 120)
    finally:
        process.send_signal(signal.SIGKILL)
        process.wait()
    there = len(list(folder.glob("train-*.tar")))
    assert 3 <= there < count / 5
    assert not (folder / "dataset.json").exists()
    result = generate(config, folder, count, shard_size=5, scheduler=scheduler)
    assert 0 < result.made <= count - 5 * (there - 1)  # the last may have had no note
    generate(config, tmp_path / "undisturbed", count, shard_size=5, scheduler=scheduler)
    for path in sorted((tmp_path / "undisturbed").glob("*.tar")):
        assert (folder / path.name).read_bytes() == path.read_bytes()
    assert len(list(read_shards(folder))) == count
    assert not [each for each in folder.iterdir() if each.name.startswith(".train")]
