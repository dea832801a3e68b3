"""Compile every kernel once, so that a first run is not spent compiling: ``python -m medial.precompile``.

Compiled code is kept on disk (see `datasets_gen.compiled`), so set-up can pay for it once. The first call of
the operator and of the matcher otherwise takes about a minute more on one core.
"""

from dataclasses import replace

import numpy as np

from medial.diffusion import Diffusion
from medial.matching.config import MatchConfig
from medial.matching.match import match
from medial.operator import OPERATORS


def warm_up() -> None:
    """Build every operator of a small capsule, and match it in both ways with few samples and restarts.

    Kernels are compiled for arrays that may be written and for those that may not: what a sweep hands to a
    method is of the second kind.
    """
    points, normals = _capsule(1500)
    default = MatchConfig(samples=120, restarts=2, partners=1, nodes=20, fine_nodes=40, finalists=1)
    paper = replace(MatchConfig.paper(), samples=100, restarts=1)
    for writable in (True, False):
        points.setflags(write=writable)
        normals.setflags(write=writable)
        for operator in OPERATORS:
            diffusion = Diffusion.from_points(points, normals, operator=operator, modes=40)
            for array in vars(diffusion).values():
                if isinstance(array, np.ndarray):
                    array.setflags(write=writable)
            match(diffusion, diffusion, paper)
            if operator == "medial":
                match(diffusion, diffusion, default)


def _capsule(count: int) -> tuple[np.ndarray, np.ndarray]:
    """Points and normals of a capsule of radius 1 and length 6, with a bump so that its ends differ."""
    k = np.arange(count) + 0.5
    along = 2 * k / count - 1
    angle = np.pi * (1 + np.sqrt(5)) * k
    ring = np.sqrt(np.maximum(1 - along**2, 0)) * (1 + 0.2 * along)
    normals = np.column_stack([ring * np.cos(angle), ring * np.sin(angle), along])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    points = normals * (1 + 0.2 * along)[:, None]
    points[:, 2] += 2 * np.sign(along) * np.minimum(1, 5 * np.abs(along))
    return points, normals


if __name__ == "__main__":
    warm_up()
