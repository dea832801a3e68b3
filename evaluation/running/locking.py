"""One run per results folder at a time."""

import contextlib
import fcntl
import os
import platform
from collections.abc import Iterator
from pathlib import Path

from datasets_gen.records import InputError


@contextlib.contextmanager
def lock(folder: Path) -> Iterator[None]:
    """Hold a results folder, created if missing; the system lets go of it even if the process is killed.

    Raises
    ------
    InputError
        If another run holds it, or it cannot be written.
    """
    path = folder / ".lock"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        stream = path.open("a+", encoding="utf-8")
    except OSError as error:
        raise InputError(
            f"cannot write {str(folder)!r}: {error.strerror}; choose a folder you can write to"
        ) from error
    with stream:
        try:
            fcntl.flock(stream, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            stream.seek(0)
            holder = stream.read().strip() or "another process"
            raise InputError(f"{str(folder)!r} is in use by {holder}; wait, or use another folder") from error
        stream.truncate(0)
        stream.write(f"process {os.getpid()} on {platform.node()}")
        stream.flush()
        yield
