"""Built bodies on disk, keyed by their parameters and by the code that makes them."""

import hashlib
import json
import logging
import os
from collections.abc import Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from datasets_gen.records import InputError, load_record, save_record
from datasets_gen.shape import Collection, Shape

_log = logging.getLogger(__name__)

LIBRARIES = ("numpy", "scipy", "scikit-image", "robust-laplacian")
KIND = "Collection"


def cache_folder() -> Path:
    """``$MEDIALBENCH_CACHE``, else ``medialbench`` in the user's cache folder."""
    own = os.environ.get("MEDIALBENCH_CACHE")
    if own:
        return Path(own)
    base = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    return (Path(base) if base else Path.home() / ".cache") / "medialbench"


@cache
def code_fingerprint() -> str:
    """Hash of this package's source and of the versions of the libraries that it computes with."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parent.rglob("*.py")):
        digest.update(path.name.encode() + b"\0" + path.read_bytes() + b"\0")
    for library in LIBRARIES:
        digest.update(f"{library} {version(library)}\n".encode())
    return digest.hexdigest()


def cache_path(name: str, parameters: Mapping[str, Any]) -> Path:
    """File of a body; changes with its parameters, with the code and with the libraries."""
    text = json.dumps({"name": name, "code": code_fingerprint(), **parameters}, sort_keys=True)
    return cache_folder() / f"{name}-{hashlib.sha256(text.encode()).hexdigest()[:20]}.npz"


def fetch(path: Path) -> Collection | None:
    """The collection in a cache file; None where there is none or it cannot be read (logged)."""
    if not path.is_file():
        return None
    try:
        arrays, meta = load_record(path, KIND)
        faces = arrays["faces"]
        shapes = tuple(
            Shape(vertices, faces, f"{meta['subject']}/{pose}", meta["subject"], pose, meta["units"])
            for pose, vertices in zip(meta["poses"], arrays["vertices"], strict=True)
        )
        mirror = arrays.get("mirror")
        return Collection(meta["subject"], shapes, shapes[meta["poses"].index(meta["reference"])], mirror)
    except (InputError, KeyError, ValueError) as error:
        _log.warning("cache file %s is not usable (%s); building it again", path, error)
        return None


def store(path: Path, collection: Collection) -> None:
    """Write a collection to a cache file; a folder that cannot be written is logged, not raised."""
    arrays: dict[str, Any] = {
        "vertices": np.stack([shape.vertices for shape in collection.shapes]),
        "faces": collection.reference.faces,
    }
    if collection.mirror is not None:
        arrays["mirror"] = collection.mirror
    meta = {
        "subject": collection.subject,
        "poses": [shape.pose for shape in collection.shapes],
        "reference": collection.reference.pose,
        "units": collection.reference.units,
    }
    try:
        save_record(path, KIND, arrays, meta)
    except (InputError, OSError) as error:
        _log.warning("going on without a cache: %s", error)
