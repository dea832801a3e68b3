"""One run per results folder at a time."""

import contextlib
import os
import platform
from collections.abc import Iterator
from pathlib import Path

from datasets_gen.records import InputError, cannot_write


@contextlib.contextmanager
def lock_folder(folder: Path) -> Iterator[None]:
    """Hold a results folder, created if missing; the system lets go of it even if the process is killed.

    Parameters
    ----------
    folder
        Gets a file ``.lock``, which stays, and beside it ``.lock-holder`` while it is held.

    Raises
    ------
    InputError
        If another process holds it (the message says which), or it cannot be written.
    """
    from filelock import FileLock, Timeout

    holder = folder / ".lock-holder"  # a file of its own: taking the lock may empty the lock file
    try:
        folder.mkdir(parents=True, exist_ok=True)
        held = FileLock(folder / ".lock", timeout=0).acquire()
    except Timeout as error:
        who = _text(holder) or "another process"
        raise InputError(f"{str(folder)!r} is in use by {who}; wait, or use another folder") from error
    except OSError as error:
        raise cannot_write(folder, error) from error
    with held:
        with contextlib.suppress(OSError):
            holder.write_text(f"process {os.getpid()} on {platform.node()}", encoding="utf-8")
        try:
            yield
        finally:
            with contextlib.suppress(OSError):
                holder.unlink(missing_ok=True)


def _text(path: Path) -> str:
    try:
        return " ".join(path.read_text(encoding="utf-8", errors="replace").split())[:80]
    except OSError:
        return ""
