"""Shapes: the poses of one subject."""

from collections.abc import Mapping
from functools import partial
from typing import Any

from datasets_gen import load
from evaluation.results.collection_file import save_collection
from evaluation.running.stages.interface import Inputs, Output


def compute(spec: Mapping[str, Any], inputs: Inputs) -> Output:
    """Load or generate a data set.

    ``spec``: ``name`` (built in, or a folder), ``options``.
    """
    collection = load(spec["name"], **spec["options"])
    info = {
        "subject": collection.subject,
        "poses": [shape.pose for shape in collection.shapes],
        "reference": collection.reference.pose,
        "area": collection.reference.area,
        "vertices": len(collection.reference.vertices),
        "mirror": collection.mirror is not None,
    }
    return Output(partial(save_collection, collection), info)
