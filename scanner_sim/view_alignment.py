"""Errors of bringing the views together, and their repair by ICP."""

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

ROUNDS = 6
SAMPLE = 2_000
"""Points of a view that are matched in each round."""
OVERLAP = 2.0
"""Points count as overlapping if nearer to the other views than this many times the typical distance."""


def disturb(
    points: NDArray[np.float64], view_ids: NDArray[np.integer], degrees: float, seed: int
) -> NDArray[np.float64]:
    """Turn each view about its centroid by an angle about a random axis.

    Parameters
    ----------
    points : (n, 3)
    view_ids : (n,)
    degrees
        The angle.
    seed

    Returns
    -------
    (n, 3) float64
    """
    out = points.copy()
    for view in np.unique(view_ids):
        mine = view_ids == view
        axis = np.random.default_rng([seed, int(view), 1]).normal(size=3)
        turn = Rotation.from_rotvec(np.radians(degrees) * axis / np.linalg.norm(axis))
        centre = points[mine].mean(axis=0)
        out[mine] = turn.apply(points[mine] - centre) + centre
    return out


def realign(points: NDArray[np.float64], view_ids: NDArray[np.integer], seed: int) -> NDArray[np.float64]:
    """Bring the views together again by ICP of each against all others, in a few rounds.

    Parameters
    ----------
    points : (n, 3)
    view_ids : (n,)
    seed
        Picks the points that are matched.

    Returns
    -------
    (n, 3) float64
    """
    from trimesh import registration, transform_points  # a third of a second to import

    out = points.copy()
    views = np.unique(view_ids)
    rng = np.random.default_rng([seed, 2])
    for _ in range(ROUNDS if len(views) > 1 else 0):
        for view in views:
            mine = np.flatnonzero(view_ids == view)
            picked = rng.permutation(mine)[:SAMPLE]
            others = out[view_ids != view]
            gap = cKDTree(others).query(out[picked])[0]
            near = picked[gap <= OVERLAP * np.median(gap)]
            if len(near) < 20:
                continue
            matrix, _, _ = registration.icp(
                out[near], others, reflection=False, scale=False, max_iterations=30
            )
            out[mine] = transform_points(out[mine], matrix)
    return out
