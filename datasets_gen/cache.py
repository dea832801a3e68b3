"""Built bodies on disk, keyed by their parameters, by the code that makes them and by its libraries."""

import logging
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from datasets_gen.collection import Collection
from datasets_gen.fingerprints import code_fingerprint, digest
from datasets_gen.paths import safe_name
from datasets_gen.records import InputError

_log = logging.getLogger(__name__)


def cache_folder() -> Path:
    """``$MEDIALBENCH_CACHE``, else ``medialbench`` in the user's cache folder."""
    own = os.environ.get("MEDIALBENCH_CACHE")
    if own:
        return Path(own)
    base = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    return (Path(base) if base else Path.home() / ".cache") / "medialbench"


def cache_path(name: str, parameters: Mapping[str, Any], *modules: str) -> Path:
    """File of a body; changes with its parameters, with the code and with the libraries.

    Parameters
    ----------
    name
        Of the body; begins the file's name.
    parameters
        Everything that decides the body besides the code; values that JSON can hold.
    *modules
        Dotted names of the modules that build it; what they import counts too.

    Returns
    -------
    Path
        In `cache_folder`; need not exist.
    """
    key = digest({"name": name, "parameters": parameters, "code": code_fingerprint(*modules)})
    return cache_folder() / f"{safe_name(name)}-{key[:20]}.npz"


def fetch(path: Path) -> Collection | None:
    """The collection in a cache file; None where there is none or it cannot be read (logged)."""
    if not path.is_file():
        return None
    try:
        return Collection.load(path)
    except InputError as error:
        _log.warning("cache file %s is not usable (%s); building it again", path, error)
        return None


def store(path: Path, collection: Collection) -> None:
    """Write a collection to a cache file; a folder that cannot be written is logged, not raised."""
    try:
        collection.save(path)
    except (InputError, OSError) as error:
        _log.warning("going on without a cache: %s", error)
