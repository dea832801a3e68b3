"""One file for all poses of a subject, so that a results folder stands by itself."""

import os
from typing import Any

import numpy as np

from datasets_gen import Collection, Shape
from datasets_gen.records import load_record, save_record


def save_collection(collection: Collection, path: str | os.PathLike[str]) -> None:
    """Write a collection as one ``.npz``."""
    reference = collection.reference
    shapes = {shape.pose: shape for shape in (reference, *collection.shapes)}
    arrays: dict[str, Any] = {
        "faces": reference.faces,
        "vertices": np.stack([shape.vertices for shape in shapes.values()]),
    }
    if collection.mirror is not None:
        arrays["mirror"] = collection.mirror
    meta = {
        "subject": collection.subject,
        "reference": reference.pose,
        "poses": [shape.pose for shape in collection.shapes],
        "stored": list(shapes),
        "names": [shape.name for shape in shapes.values()],
        "units": reference.units,
    }
    save_record(path, "Collection", arrays, meta)


def load_collection(path: str | os.PathLike[str]) -> Collection:
    """Read a file written by `save_collection`."""
    arrays, meta = load_record(path, "Collection")
    shapes = {
        pose: Shape(vertices, arrays["faces"], name, meta["subject"], pose, meta["units"])
        for pose, name, vertices in zip(meta["stored"], meta["names"], arrays["vertices"], strict=True)
    }
    return Collection(
        subject=meta["subject"],
        shapes=tuple(shapes[pose] for pose in meta["poses"]),
        reference=shapes[meta["reference"]],
        mirror=arrays.get("mirror"),
    )
