"""Stages that compute next to nothing, but from their settings and all of their inputs, and store files.

The program is imported where it is needed and by name: what a stage imports belongs to the keys of its
results, and to read all of it takes longer than the sweep.
"""

import hashlib
import json
import os
import time
from functools import partial
from importlib import import_module

import numpy as np

LIGHT = dict.fromkeys(("shape", "render", "scan", "operator", "map", "score"), __name__)
"""Module by stage, as `evaluation.experiment.tasks.STAGES`."""
SECONDS = "MEDIALBENCH_TEST_SECONDS"
"""Environment variable: how long each task takes."""


def compute(spec, inputs):
    """Any stage; a change in an input changes what comes out."""
    time.sleep(float(os.environ.get(SECONDS, 0)))
    values = {role: inputs.note(role)["value"] for role in inputs.keys}
    value = hashlib.sha256(json.dumps([spec, values], sort_keys=True).encode()).hexdigest()
    number = int(value[:8], 16) / 2**32
    output = import_module("evaluation.running.stages.interface").Output
    info = {"value": value, "variant": "none", "missing": number}
    if "kind" in spec:  # a score
        measured = "eq18" if spec["kind"] == "stability" else "geodesic_mean"
        return output(None, {**info, "row": {measured: number, "n_points": int(1000 * number)}})
    if "name" in spec:  # a data set
        info |= import_module("datasets_gen.registry").outline(spec["name"], **spec["options"])
    numbers = np.random.default_rng(int(value[:8], 16)).random(400)
    save = import_module("datasets_gen.records").save_record
    return output(partial(save, kind="Light", arrays={"numbers": numbers}, meta={}), info)
