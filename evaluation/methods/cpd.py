"""Coherent point drift [Myronenko & Song 2010], with the `pycpd` package."""

from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from datasets_gen.values import check_count
from evaluation.experiment.toml_tables import expect
from evaluation.methods.base import Method, MethodInput, dense, require
from evaluation.methods.rigid import align, thinned
from medial import Matching
from medial.matching.confidence import confidence_of_residual

FEWEST = 10
"""Points that can be registered."""


@dataclass(frozen=True, kw_only=True)
class CoherentPointDrift(Method):
    """Rigid alignment, then a smooth displacement of a subset of the source that the other points follow."""

    samples: int = 800
    """Points of either cloud that are registered: the cost grows with their cube."""
    alpha: float = 2.0
    """Weight of smoothness."""
    beta: float = 0.3
    """Width of the displacement's kernel, in root mean square distances from the centroid."""
    outliers: float = 0.2
    """Assumed share of points without a counterpart."""
    iterations: int = 100

    def __post_init__(self) -> None:
        """Check ranges."""
        check_count(self.samples, "samples", FEWEST)
        check_count(self.iterations, "iterations")
        expect(self.alpha > 0, f"alpha must be positive, got {self.alpha!r}")
        expect(self.beta > 0, f"beta must be positive, got {self.beta!r}")
        expect(0 <= self.outliers < 1, f"outliers must lie in [0, 1), got {self.outliers!r}")

    requires = {"pycpd": "pycpd"}  # noqa: RUF012

    def match(self, source: MethodInput, target: MethodInput, seed: int) -> Matching:
        """Nearest target point of every displaced source point."""
        from pycpd import DeformableRegistration

        require(min(len(source), len(target)), FEWEST, "coherent point drift")
        placed = align(source.points, target.points, 30, 1500, seed)
        centre = target.points.mean(axis=0)
        unit = np.sqrt(((target.points - centre) ** 2).sum(axis=1).mean())
        moving, fixed = (placed - centre) / unit, (target.points - centre) / unit
        nodes = moving[thinned(moving, self.samples, seed)]
        registration = DeformableRegistration(
            X=fixed[thinned(fixed, self.samples, seed)],
            Y=nodes,
            alpha=self.alpha,
            beta=self.beta,
            w=self.outliers,
            max_iterations=self.iterations,
        )
        _, (_, weights) = registration.register()
        square = ((moving[:, None] - nodes[None]) ** 2).sum(axis=2)  # (n, samples)
        moved = moving + np.exp(-square / (2 * self.beta**2)) @ weights
        distance, nearest = cKDTree(fixed).query(moved)
        return dense(nearest, confidence_of_residual(distance), cost=float(distance.mean()), seed=seed)
