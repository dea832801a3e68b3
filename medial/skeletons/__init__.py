"""Curve skeletons of incomplete clouds: what the paper compares with (Fig. 10), and one of medial centres.

Read `rosa` first, the method of [TZCO09] in the order of its steps: `surface_graph` (which points are
neighbours), `cutting_planes` (directions and centres; `equations` says what is computed), `skeletal_cloud`
and `thinning` (centres drawn together to curves), `line_extraction`, `graph_cleaning` and `joint_places`
(curves to a graph).
`medial_curves` takes the medial centres of Eq. 9 instead and shares the rest. `local_separators` calls the
package of [BR21]. `curve_skeleton` is the result, `skeleton_files` writes it, `skeleton_methods` names all.
"""

from medial.skeletons.curve_skeleton import CurveSkeleton
from medial.skeletons.medial_curves import medial_skeleton
from medial.skeletons.rosa import RosaSettings, rosa_skeleton
from medial.skeletons.skeleton_files import write_skeleton
from medial.skeletons.skeleton_methods import SKELETON_METHODS, skeleton_of

__all__ = [
    "SKELETON_METHODS",
    "CurveSkeleton",
    "RosaSettings",
    "medial_skeleton",
    "rosa_skeleton",
    "skeleton_of",
    "write_skeleton",
]
