"""A disk that is full, read-only, broken or out of descriptors at one step of a sweep, or from then on."""

import contextlib
import errno
import re
import subprocess

import pytest
from click.testing import CliRunner

from datasets_gen import InputError, cache
from reports.cli.main import cli
from tests.datasets_gen.test_cache import ball
from tests.faults.failing_calls import REMOVES, WRITES, FailingCalls, failing
from tests.faults.sweep import TASKS, check_finished, check_whole, command, run_here

ERRORS = (errno.ENOSPC, errno.EMFILE, errno.EROFS, errno.EIO, errno.EACCES)


def calls_of(settings, folder, monkeypatch, events=WRITES):
    """How many calls a sweep makes."""
    with failing(FailingCalls(folder, 0, events=events)) as calls:
        run_here(settings, folder, monkeypatch)
    return calls.calls


def disturbed(settings, folder, monkeypatch, calls):
    """Run with calls that fail; whatever ends or fails because of them says so in one line with the path."""
    lines = []
    with failing(calls):
        try:
            store = run_here(settings, folder, monkeypatch)
        except InputError as error:
            lines.append(str(error))
        else:
            failures = store.failures()
            lines += failures[failures.kind == "error"].reason.tolist()
    for line in lines:
        assert "\n" not in line
        assert str(folder) in line
    return lines


def recovered(settings, folder, monkeypatch, expected):
    if folder.exists():
        check_whole(folder)
    run_here(settings, folder, monkeypatch)
    check_finished(folder, expected)


def test_the_sweep_is_as_large_as_it_is_said_to_be(settings, undisturbed, tmp_path, monkeypatch):
    run_here(settings[0], tmp_path / "results", monkeypatch)
    check_finished(tmp_path / "results", undisturbed)
    assert len(undisturbed) == 6
    assert calls_of(settings[0], tmp_path / "again", monkeypatch) > 5 * TASKS


def inject(error, step, settings, folder, monkeypatch, expected, injected, events=WRITES):
    """Fail at every `step`-th call, alone and with all that follow; the sweep goes on then."""
    total = calls_of(settings, folder / "count", monkeypatch, events)
    for first in range(1, total + 1, step):
        for last in (first, None):
            place = folder / f"{first}-{last}"
            calls = FailingCalls(place, error, first, last, events)
            lines = disturbed(settings, place, monkeypatch, calls)
            assert calls.failed
            injected(errno.errorcode[error])
            if error == errno.ENOSPC and last is None:
                assert any("No space left on device; free some space" in line for line in lines)
            recovered(settings, place, monkeypatch, expected)


@pytest.mark.parametrize("error", ERRORS[:2], ids=errno.errorcode.get)
def test_calls_that_fail(error, settings, undisturbed, tmp_path, monkeypatch, injected):
    inject(error, 61, settings[0], tmp_path, monkeypatch, undisturbed, injected)


@pytest.mark.long
@pytest.mark.slow
@pytest.mark.parametrize("error", ERRORS, ids=errno.errorcode.get)
def test_each_call_that_fails(error, settings, undisturbed, tmp_path, monkeypatch, injected):
    step = 3 if error == errno.ENOSPC else 13
    inject(error, step, settings[0], tmp_path, monkeypatch, undisturbed, injected)


def test_files_that_cannot_be_removed(settings, undisturbed, tmp_path, monkeypatch, injected):
    inject(errno.EACCES, 21, settings[0], tmp_path, monkeypatch, undisturbed, injected, REMOVES)


@contextlib.contextmanager
def mounted(place, *options):
    """A file system of its own at a place; skips where this user cannot mount one."""
    place.mkdir()
    done = subprocess.run(["mount", *options, str(place)], capture_output=True, text=True, check=False)
    if done.returncode:
        pytest.skip(f"cannot mount: {done.stderr.strip()}")
    try:
        yield place
    finally:
        subprocess.run(["umount", "-l", str(place)], check=True)


def remount(place, options):
    subprocess.run(["mount", "-o", f"remount,{options}", str(place)], check=True)


def fill(settings, tmp_path, monkeypatch, expected, injected, sizes, unit):
    """A sweep on a disk of each size, then on one that is large enough."""
    for size in sizes:
        place = tmp_path / f"{unit}-{size}"
        with mounted(place, "-t", "tmpfs", "-o", f"{unit}={size}", "tmpfs"):
            folder = place / "results"
            if not disturbed(settings, folder, monkeypatch, FailingCalls(folder, 0)):
                check_finished(folder, expected)
                continue
            injected(f"full disk ({unit})")
            remount(place, f"{unit}=0")  # no limit
            recovered(settings, folder, monkeypatch, expected)


def test_a_disk_that_is_full(settings, undisturbed, tmp_path, monkeypatch, injected):
    sizes = [f"{pages * 4}k" for pages in (1, 20, 40, 60)]
    fill(settings[0], tmp_path, monkeypatch, undisturbed, injected, sizes, "size")


@pytest.mark.long
@pytest.mark.slow
def test_disks_of_every_size(settings, undisturbed, tmp_path, monkeypatch, injected):
    sizes = [f"{pages * 4}k" for pages in range(1, 90, 2)]
    fill(settings[0], tmp_path, monkeypatch, undisturbed, injected, sizes, "size")
    fill(settings[0], tmp_path, monkeypatch, undisturbed, injected, range(2, 70, 3), "nr_inodes")


@pytest.mark.parametrize("state", ["first", "finished"])
def test_a_folder_that_is_mounted_read_only(state, settings, undisturbed, tmp_path, monkeypatch, injected):
    with mounted(tmp_path / "disk", "-t", "tmpfs", "tmpfs") as place:
        folder = place / "results"
        if state == "finished":
            run_here(settings[0], folder, monkeypatch)
        remount(place, "ro")
        injected("read-only folder")
        with pytest.raises(InputError, match=r"cannot write .*Read-only file system; choose a folder"):
            run_here(settings[0], folder, monkeypatch)
        said = CliRunner().invoke(cli, command(settings[1], folder)[3:])
        assert said.exit_code == 1
        assert re.fullmatch(r"medialbench: cannot write .*\n", said.stderr)
        assert str(folder) in said.stderr
        remount(place, "rw")
        recovered(settings[0], folder, monkeypatch, undisturbed)


def test_a_cache_that_cannot_be_written_is_done_without(tmp_path, caplog, injected):
    """At every call; there is nothing in it afterwards, or all."""
    whole = tmp_path / "whole.npz"
    cache.store(whole, ball())
    for error in ERRORS:
        for first in range(1, 5):  # create the folder, create the file, open it, set its mode
            path = tmp_path / f"{error}-{first}" / "body.npz"
            caplog.clear()
            with failing(FailingCalls(path.parent, error, first, first)) as calls:
                cache.store(path, ball())
            assert calls.failed == 1
            assert "going on without a cache" in caplog.text
            assert not list(path.parent.glob("*"))
            cache.store(path, ball())
            assert path.read_bytes() == whole.read_bytes()
            injected(f"cache {errno.errorcode[error]}")
