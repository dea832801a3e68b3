"""A curve skeleton from the medial centres of the operator (Eq. 9), contracted and thinned."""

import numpy as np
from numpy.typing import NDArray

from medial.areas.dual_area import medial_balls
from medial.areas.surface_cells import density_weights, surface_areas
from medial.places import distinct_places
from medial.similarity.similarity import similarity
from medial.skeletons.curve_skeleton import CurveSkeleton
from medial.skeletons.joint_places import settled_joints
from medial.skeletons.rosa import check_enough, recentred
from medial.skeletons.skeletal_cloud import LEAST_TUBULAR, SkeletalCloud, as_skeleton, curve_graph
from medial.skeletons.surface_graph import SurfaceGraph

Float = NDArray[np.float64]

NEIGHBOURS = 10
ROUNDS = 40
"""Of shrinking: medial sheets are wider than what symmetry centres scatter."""
STEP, RECENTRING = 0.7, 1.0
"""As of `medial.skeletons.rosa.RosaSettings`."""
NO_CENTER = (
    "{share:.0f} % of the points have a medial centre inside something that is no sheet; "
    "a flat shape has no curve skeleton"
)


def medial_skeleton(
    points: NDArray[np.floating], normals: NDArray[np.floating] | None = None, step: float = STEP
) -> CurveSkeleton:
    """The curve skeleton along the medial centres of a cloud.

    Each point's centre is the average of its candidate balls over all similar points (Eq. 9), so that one
    side of a limb is enough where the other one is missing. Points with centres near each other belong
    together, also across gaps; sheets are contracted.

    Parameters
    ----------
    points : (n, 3)
    normals : (n, 3) or None
        Outward; None estimates them, and the log says so.
    step
        Between nodes, in radii of the body.

    Returns
    -------
    CurveSkeleton
        As of `medial.skeletons.rosa.rosa_skeleton`.

    Raises
    ------
    InputError
        If the cloud cannot be used.
    """
    places = distinct_places(points, normals)
    cloud = places.cloud
    check_enough(len(cloud), NEIGHBOURS)
    weights = density_weights(surface_areas(cloud.points, cloud.normals))
    phi = similarity(cloud.points, cloud.normals, weights=weights)
    graph = SurfaceGraph.of(cloud.points, cloud.normals, NEIGHBOURS)
    balls = SkeletalCloud(graph, *medial_balls(cloud, phi), np.diff(phi.indptr) > 0).inside().without_sheets()
    share = float(balls.known.mean())
    if share < LEAST_TUBULAR:
        return CurveSkeleton.empty(len(places.points), "medial", NO_CENTER.format(share=100 * share))
    thin = balls.thinned(ROUNDS)
    curves, ids = curve_graph(thin, step)
    recentred(curves, ids, balls, RECENTRING)
    settled_joints(curves)
    return as_skeleton(curves, ids, thin, places.index, "medial")
