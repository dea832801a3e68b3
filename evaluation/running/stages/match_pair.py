"""Maps: the correspondence that a method finds for a pair of clouds."""

from collections.abc import Mapping
from typing import Any

import numpy as np

from datasets_gen import InputError
from datasets_gen.fingerprints import library_versions
from evaluation.methods.base import Method, MethodInput
from evaluation.methods.catalogue import METHODS, create
from evaluation.running.stages.interface import Inputs, Output
from medial import Matching


def compute(spec: Mapping[str, Any], inputs: Inputs) -> Output:
    """Match two clouds.

    ``spec``: ``method``, ``options``, ``seed``. Inputs: ``shape``, ``source_scan``, ``target_scan`` and
    ``source_<operator>``, ``target_<operator>`` for every operator that the method asks for.

    Info: ``mirror_check`` and ``cost`` of the map; ``method_versions``: libraries that the method imports.

    Raises
    ------
    InputError
        If the method refuses the clouds, or returns what is no map between them.
    """
    method = create(spec["method"], spec["options"])
    source, target = (_cloud(side, method, inputs) for side in ("source", "target"))
    found = method.match(source, target, seed=spec["seed"])
    check(found, len(source), len(target))
    home = METHODS.get(spec["method"], spec["method"]).rpartition(":")[0]
    info = {"mirror_check": found.mirror_check, "cost": float(found.cost)}
    return Output(found.save, {**info, "method_versions": library_versions(home)})


def _cloud(side: str, method: Method, inputs: Inputs) -> MethodInput:
    scan = inputs.load(f"{side}_scan")
    return MethodInput(
        name=inputs.keys[f"{side}_scan"],
        scan=scan,
        operators={each: inputs.load(f"{side}_{each}") for each in method.operators},
        truth=inputs.load("shape").reference.at(scan.face_ids, scan.barycentrics)
        if method.uses_truth
        else None,
    )


def check(found: Matching, n_source: int, n_target: int) -> None:
    """Raise unless a method returned what its interface promises."""
    ids, confidence = found.source_to_target, found.confidence
    if ids.shape != (n_source,) or not np.issubdtype(ids.dtype, np.integer):
        raise InputError(
            f"the method returned a map of shape {ids.shape}, type {ids.dtype}, not ({n_source},) integer"
        )
    if n_source and not -1 <= ids.min() <= ids.max() < n_target:
        raise InputError(
            f"the method returned target ids {ids.min()} to {ids.max()}, not in [-1, {n_target})"
        )
    if confidence.shape != (n_source,) or not ((confidence >= 0) & (confidence <= 1)).all():
        raise InputError("the method returned no confidence in [0, 1] for every source point")
