"""Maps: the correspondence that a method finds for a pair of clouds."""

from collections.abc import Mapping
from copy import deepcopy
from math import isfinite
from typing import Any

from datasets_gen.fingerprints import library_versions
from evaluation.methods.base import Method, MethodInput
from evaluation.methods.catalogue import METHODS, create
from evaluation.methods.returned_map import checked_map
from evaluation.running.read_only import private
from evaluation.running.stages.interface import Inputs, Output
from evaluation.running.surroundings import kept_surroundings


def compute(spec: Mapping[str, Any], inputs: Inputs) -> Output:
    """Match two clouds. The method gets copies of its own: what it does to them stays with it.

    ``spec``: ``method``, ``options``, ``seed``. Inputs: ``shape``, ``source_scan``, ``target_scan`` and
    ``source_<operator>``, ``target_<operator>`` for every operator that the method asks for.

    Info: ``mirror_check`` and ``cost`` of the map (None if it is not finite); ``method_versions``: libraries
    that the method imports.

    Raises
    ------
    InputError
        If the method refuses the clouds, or returns what is no map between them.
    """
    method = create(spec["method"], deepcopy(spec["options"]))
    source, target = (_cloud(side, method, inputs) for side in ("source", "target"))
    with kept_surroundings(spec["seed"]):
        returned = method.match(source, target, seed=spec["seed"])
    found = checked_map(returned, len(source), len(target))
    home = METHODS.get(spec["method"], spec["method"]).rpartition(":")[0]
    info = {"mirror_check": found.mirror_check, "cost": found.cost if isfinite(found.cost) else None}
    return Output(found.save, {**info, "method_versions": library_versions(home)})


def _cloud(side: str, method: Method, inputs: Inputs) -> MethodInput:
    scan = inputs.load(f"{side}_scan")
    cloud = MethodInput(
        name=inputs.keys[f"{side}_scan"],
        scan=scan,
        operators={each: inputs.load(f"{side}_{each}") for each in method.operators},
        truth=inputs.load("shape").reference.at(scan.face_ids, scan.barycentrics)
        if method.uses_truth
        else None,
    )
    return private(cloud)
