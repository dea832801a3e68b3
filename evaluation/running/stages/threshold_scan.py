"""Scans: the cloud that a threshold and a number of points make of a render, or a complete ideal sampling."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

from datasets_gen import Collection, InputError, Shape
from evaluation.running.stages.interface import Inputs, Output
from scanner_sim import Scan, coverage, sample

PROBES = 10_000
"""Points by which it is measured what a part lacks: about four within 1 % of the diagonal of a body."""


def compute(spec: Mapping[str, Any], inputs: Inputs) -> Output:
    """Accept, thin out and move.

    ``spec``: ``pose``, ``points``, ``seed`` and either ``ideal``, or ``rotation`` (degrees), ``scale`` and
    one of ``threshold`` and ``surface``. Inputs: ``shape`` and, with a threshold, ``render``.

    Info: ``points``, and ``missing``: the share of the surface that has no accepted scan point within 1 %
    of the bounding box's diagonal, before thinning; of a surface that is sampled as it is, the share of the
    reference that it lacks (`lacking`).
    """
    collection: Collection = inputs.load("shape")
    shape = collection[spec["pose"]]
    if spec.get("ideal"):
        cloud = on_reference(sample(shape, spec["points"], seed=spec["seed"]), collection, shape)
        return Output(cloud.save, {"points": len(cloud), "missing": 0.0})
    if spec.get("surface"):
        cloud = moved(on_reference(sample(shape, spec["points"], seed=spec["seed"]), collection, shape), spec)
        return Output(cloud.save, {"points": len(cloud), "missing": lacking(collection, shape)})
    accepted = inputs.load("render").accept(spec["threshold"])
    if len(accepted) == 0:
        raise InputError(
            f"no point of {shape.name!r} reaches the peak threshold {spec['threshold']}; lower it"
        )
    missing = 1 - coverage(accepted, shape)
    thinned = accepted.subsample(spec["points"], seed=spec["seed"])
    cloud = moved(on_reference(thinned, collection, shape), spec)
    return Output(cloud.save, {"points": len(cloud), "missing": missing})


def on_reference(cloud: Scan, collection: Collection, shape: Shape) -> Scan:
    """The cloud with its ground truth on the reference, where every score looks for it."""
    faces, barycentrics = collection.on_reference(shape, cloud.face_ids, cloud.barycentrics)
    return replace(cloud, face_ids=faces, barycentrics=barycentrics)


def lacking(collection: Collection, shape: Shape) -> float:
    """Share of the reference's area with no point of a shape's surface within 1 % of the diagonal.

    Zero for a pose of all of the subject; for a part, that which was cut away.
    """
    if shape.pose not in collection.placements:
        return 0.0
    reference = collection.reference
    cloud = on_reference(sample(shape, PROBES), collection, shape)
    return 1 - coverage(
        replace(cloud, true_points=reference.at(cloud.face_ids, cloud.barycentrics)), reference
    )


def moved(cloud: Scan, spec: Mapping[str, Any]) -> Scan:
    """The cloud turned by ``rotation`` degrees about a random axis and scaled."""
    if not spec["rotation"] and spec["scale"] == 1:
        return cloud
    axis = np.random.default_rng(spec["seed"]).normal(size=3)
    turn = Rotation.from_rotvec(np.radians(spec["rotation"]) * axis / np.linalg.norm(axis)).as_matrix()
    return replace(
        cloud,
        points=spec["scale"] * cloud.points @ turn.T,
        true_points=spec["scale"] * cloud.true_points @ turn.T,
        normals=cloud.normals @ turn.T,
    )
