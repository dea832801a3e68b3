"""Medial diffusion [Berger & Silva 2012] and its baselines, on oriented point clouds."""

from medial.areas.dual_area import dual_areas, medial_axis
from medial.areas.surface_cells import density_weights, surface_areas
from medial.diffusion import Diffusion
from medial.matching.config import MatchConfig, Matching
from medial.matching.match import extrapolate, match
from medial.similarity.similarity import similarity
from medial.symmetry import intrinsic_symmetry

__all__ = [
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
