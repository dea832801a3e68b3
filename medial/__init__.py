"""Medial diffusion [Berger & Silva 2012] and its baselines, on oriented point clouds."""

from medial.area import dual_areas, medial_axis
from medial.diffusion import Diffusion
from medial.matching import extrapolate, match
from medial.matching_types import MatchConfig, Matching
from medial.similarity import similarity
from medial.surface import density_weights, surface_areas
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
