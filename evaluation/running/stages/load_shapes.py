"""Shapes: the poses of one subject."""

from collections.abc import Mapping
from typing import Any

from datasets_gen import load
from evaluation.running.stages.interface import Inputs, Output


def compute(spec: Mapping[str, Any], inputs: Inputs) -> Output:
    """Load or generate a data set.

    ``spec``: ``name`` (built in, or a folder), ``options``.
    """
    collection = load(spec["name"], **spec["options"])
    info = {
        "subject": collection.subject,
        "poses": list(collection.poses),
        "reference": collection.reference.pose,
        "area": collection.reference.area,
        "vertices": len(collection.reference.vertices),
        "mirror": collection.mirror is not None,
    }
    return Output(collection.save, info)
