"""Medial diffusion [Berger & Silva 2012], matching by it, and baselines, on oriented point clouds.

Read `paper` first: the operator from its equations alone; `docs/paper.md` lists all 18. Then, in this order:

* `operator`: settings of an operator, and what is built in which order
* `similarity` (Eqs. 4-7), `areas` (1, 9-10), `laplacian` (2-3, 8, 14-15), `spectrum` (11-13): one per step;
  in each, `equations` says what is computed, and the other modules compute it fast.
* `diffusion`: the result, and its heat kernel
* `matching` (Sec. 4, Eqs. 16-17 and what goes beyond them) and `symmetry` (Sec. 5.2)
* `departures`: what differs from the paper, each to be switched off by name
* `places`, `outward`, `sides`, `validation`: what is done to a cloud before an operator is built
* `device`: the same on a GPU, which no reader needs; `precompile`: run once after installation

Constants at the head of a module decide results: change one and every map changes with it. Task sizes
(`..._PER_TASK`, `..._AT_ONCE`) and `device` can be changed without harm, but for the last digits.
"""

from medial.areas.dual_area import dual_areas, medial_axis
from medial.areas.surface_cells import density_weights, surface_areas
from medial.departures import Departures
from medial.diffusion import Diffusion
from medial.matching.config import MatchConfig
from medial.matching.match import extrapolate, match
from medial.matching.result import Matching
from medial.similarity.similarity import similarity
from medial.symmetry import intrinsic_symmetry

__all__ = [
    "Departures",
    "Diffusion",
    "MatchConfig",
    "Matching",
    "density_weights",
    "dual_areas",
    "extrapolate",
    "intrinsic_symmetry",
    "match",
    "medial_axis",
    "similarity",
    "surface_areas",
]
