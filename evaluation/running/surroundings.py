"""What a method may change of the process that runs it, put back for the methods after it."""

import contextlib
import os
import random
import sys
import warnings
from collections.abc import Iterator

import numpy as np

try:
    import resource
except ImportError:  # Windows
    resource = None  # type: ignore[assignment]


@contextlib.contextmanager
def kept_surroundings(seed: int) -> Iterator[None]:
    """A block after which the process is as before, and whose global random numbers are drawn from a seed.

    Put back are the filters of warnings, NumPy's handling of floating-point errors, the generators of
    `random` and of `numpy.random`, the environment, the working folder, the mask of new files, the limits of
    recursion and of the process, where modules are looked for, and those that were imported before. A process
    whose limits cannot be put back is ended: the tasks after this one would fail for it.

    Parameters
    ----------
    seed
        Of the generators.
    """
    drawn, environment = random.getstate(), dict(os.environ)
    drawn_numpy = np.random.get_state()  # noqa: NPY002 - methods may use it
    folder, mask, depth = _working_folder(), os.umask(0o022), sys.getrecursionlimit()
    path, modules, limits = list(sys.path), dict(sys.modules), _limits()
    os.umask(mask)
    random.seed(seed)
    np.random.seed(seed % 2**32)  # noqa: NPY002
    try:
        with warnings.catch_warnings(), np.errstate():
            yield
    finally:
        random.setstate(drawn)
        np.random.set_state(drawn_numpy)  # noqa: NPY002
        if os.environ != environment:
            os.environ.clear()
            os.environ.update(environment)
        if folder and _working_folder() != folder:
            with contextlib.suppress(OSError):  # removed meanwhile
                os.chdir(folder)
        os.umask(mask)
        sys.setrecursionlimit(depth)
        sys.path[:] = path
        sys.modules.update(modules)
        _put_back(limits)


def _limits() -> dict[int, tuple[int, int]]:
    """Soft and hard limits of what this process may take: open files, memory, time and so on."""
    if resource is None:
        return {}
    numbers = {getattr(resource, name) for name in dir(resource) if name.startswith("RLIMIT_")}
    return {number: resource.getrlimit(number) for number in numbers}


def _put_back(limits: dict[int, tuple[int, int]]) -> None:
    """Set limits again; end the process where that is not allowed."""
    for number, limit in limits.items():
        if resource.getrlimit(number) != limit:
            try:
                resource.setrlimit(number, limit)
            except (OSError, ValueError):  # only root raises a hard limit
                os._exit(1)


def _working_folder() -> str:
    """Empty if it is gone."""
    try:
        return os.getcwd()
    except OSError:
        return ""
