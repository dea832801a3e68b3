r"""Curve skeletons by rotational symmetry axes (ROSA) [TZCO09], the steps in the order of the paper.

A cutting plane through a point is best where the normals of the surface along the cut are orthogonal to the
plane's normal, all alike: their variance along it is least. The centre of the cut is the point nearest to the
lines through the surface points along their normals. Both need normals only, so that a part of a
cross-section is enough.

References
----------
[TZCO09] A. Tagliasacchi, H. Zhang, D. Cohen-Or, "Curve skeleton extraction from incomplete point cloud",
ACM Transactions on Graphics 28(3), 2009.
"""

from dataclasses import dataclass

import networkx as nx
import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError
from datasets_gen.values import CheckedSettings, check_count
from medial.places import distinct_places
from medial.skeletons.curve_skeleton import CurveSkeleton
from medial.skeletons.cutting_planes import symmetry_axes, symmetry_directions
from medial.skeletons.joint_places import settled_joints
from medial.skeletons.skeletal_cloud import LEAST_TUBULAR, NO_TUBE, SkeletalCloud, as_skeleton, curve_graph
from medial.skeletons.surface_graph import SurfaceGraph

Float = NDArray[np.float64]


@dataclass(frozen=True, kw_only=True)
class RosaSettings(CheckedSettings):
    """Settings of the extraction, in the order in which they matter."""

    neighbours: int = 10
    """Nearest points that are joined to a point."""
    thickness: float = 1.0
    """Largest distance of a plane's points from it, in spacings of the cloud."""
    plane_rounds: int = 10
    """Updates of the planes; the authors' program says that no more than 10 are needed."""
    thinning_rounds: int = 20
    """Rounds of shrinking and smoothing; 20 in the authors' program."""
    step: float = 0.7
    """Between samples of the curves, in radii of the body."""
    recentring: float = 1.0
    """How far nodes outside joints move from the thinned centres to the mean of the original ones, 0 to 1."""

    def __post_init__(self) -> None:
        """Check types and ranges."""
        self.check_types()
        for name, least in (("neighbours", 3), ("plane_rounds", 1), ("thinning_rounds", 0)):
            check_count(getattr(self, name), name, least)
        for name, value in (("thickness", self.thickness), ("step", self.step)):
            if not value > 0:
                raise InputError(f"{name} is {value!r}; give a number above 0")
        if not 0 <= self.recentring <= 1:
            raise InputError(f"recentring is {self.recentring!r}; give a number from 0 to 1")


def rosa_skeleton(
    points: NDArray[np.floating],
    normals: NDArray[np.floating] | None = None,
    settings: RosaSettings | None = None,
) -> CurveSkeleton:
    """The curve skeleton of an oriented cloud.

    Time and memory grow like n^1.5, as the points of all planes are visited: `docs/skeletons.md` has numbers.

    Parameters
    ----------
    points : (n, 3)
    normals : (n, 3) or None
        Outward; None estimates them, and the log says so.
    settings

    Returns
    -------
    CurveSkeleton
        Without nodes where nothing is tubular, as of a sheet, and of one node where there is no curve, as of
        a ball; `CurveSkeleton.reason` says why.

    Raises
    ------
    InputError
        If the cloud cannot be used, or has no more points than `RosaSettings.neighbours`.
    """
    chosen = settings or RosaSettings()
    places = distinct_places(points, normals)
    check_enough(len(places.cloud), chosen.neighbours)
    graph = SurfaceGraph.of(places.cloud.points, places.cloud.normals, chosen.neighbours)
    centers = symmetry_centers(graph, chosen)
    share = float(centers.known.mean())
    if share < LEAST_TUBULAR:
        return CurveSkeleton.empty(len(places.points), "rosa", NO_TUBE.format(share=100 * share))
    thin = centers.thinned(chosen.thinning_rounds)
    curves, ids = curve_graph(thin, chosen.step)
    recentred(curves, ids, centers, chosen.recentring)
    settled_joints(curves)
    return as_skeleton(curves, ids, thin, places.index, "rosa")


def check_enough(points: int, neighbours: int) -> None:
    """Raise InputError unless a cloud has more points than each is joined to."""
    if points <= neighbours:
        raise InputError(
            f"{points} distinct points are too few for a skeleton from {neighbours} neighbours each; "
            "give more points, or fewer neighbours"
        )


def symmetry_centers(graph: SurfaceGraph, settings: RosaSettings) -> SkeletalCloud:
    """Symmetry centres of all points, found twice.

    The second time a plane also reaches parts of the same limb beyond gaps: where the first centres are near
    each other. (The published neighbourhoods bridge gaps by a radius that is chosen for every shape.)
    """
    thickness, joined = settings.thickness * graph.spacing, graph
    for _ in range(2):
        axes = symmetry_axes(joined, symmetry_directions(joined, thickness, settings.plane_rounds), thickness)
        found = SkeletalCloud(graph, axes.centers, axes.radii, axes.tubular).inside()
        joined = found.joined()
    return found


def recentred(graph: nx.Graph, ids: NDArray[np.int64], centers: SkeletalCloud, share: float) -> None:
    """Move nodes outside joints towards the mean of the symmetry centres of their points; in place.

    Centres farther from the node than the body's radius do not count.

    Parameters
    ----------
    graph, ids
        Of `curve_graph`.
    centers
        Before thinning, which cuts corners.
    share
        Of the way.
    """
    for node in graph.nodes:
        members = ids[graph.nodes[node]["members"]]
        place, radius = graph.nodes[node]["place"], graph.nodes[node]["radius"]
        near = np.linalg.norm(centers.centers[members] - place, axis=1) < radius
        members = members[centers.known[members] & near]
        if graph.degree[node] <= 2 and len(members):
            middle = centers.centers[members].mean(axis=0)
            graph.nodes[node]["place"] += share * (middle - graph.nodes[node]["place"])
