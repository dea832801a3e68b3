"""Operators: the modes of a Laplacian on a cloud."""

from collections.abc import Mapping
from typing import Any

from evaluation.running.stages.interface import Inputs, Output
from medial import Diffusion


def compute(spec: Mapping[str, Any], inputs: Inputs) -> Output:
    """Build an operator.

    ``spec``: ``operator``, ``modes``, ``options`` of `Diffusion.from_points`. Inputs: ``scan``.
    """
    cloud = inputs.load("scan")
    diffusion = Diffusion.from_points(
        cloud.points, cloud.normals, operator=spec["operator"], modes=spec["modes"], **spec["options"]
    )
    return Output(diffusion.save, {"points": len(diffusion)})
