"""Curve skeletons by local separators [BR21], from the package `pygel3d`, an extra: the best-kept peer.

[BR21] A. Baerentzen, E. Rotenberg, "Skeletonization via local separators", ACM Transactions on Graphics
40(5), 2021.
"""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from importlib.util import find_spec

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.extras import pip_install
from datasets_gen.records import InputError
from medial.places import distinct_places
from medial.skeletons.curve_skeleton import CurveSkeleton
from medial.skeletons.rosa import check_enough
from medial.skeletons.surface_graph import SurfaceGraph

NEIGHBOURS = 10


def separator_skeleton(
    points: NDArray[np.floating], normals: NDArray[np.floating] | None = None
) -> CurveSkeleton:
    """The curve skeleton by local separators of the graph of neighbours.

    Its nodes are means of closed rings of points; where a side of a limb is missing they lie on the other.

    Parameters
    ----------
    points : (n, 3)
    normals : (n, 3) or None
        Outward, for telling apart parts that are close to each other; None estimates them.

    Returns
    -------
    CurveSkeleton
        Points belong to the nearest node.

    Raises
    ------
    InputError
        If `pygel3d` is not installed, or the cloud cannot be used.
    """
    if find_spec("pygel3d") is None:
        raise InputError(f"the method 'local-separators' needs pygel3d: {pip_install('skeletons')}")
    from pygel3d import graph as gel

    places = distinct_places(points, normals)
    check_enough(len(places.cloud), NEIGHBOURS)
    surface = SurfaceGraph.of(places.cloud.points, places.cloud.normals, NEIGHBOURS)
    whole = gel.Graph()
    for point in surface.points:
        whole.add_node(point)
    for a, b in surface.pairs.tolist():
        whole.connect_nodes(a, b)
    with _quiet():
        found = gel.LS_skeleton(whole, sampling=True)
    found.cleanup()
    nodes = np.array(found.positions(), dtype=np.float64).reshape(-1, 3)
    pairs = {tuple(sorted((int(a), int(b)))) for a in found.nodes() for b in found.neighbors(a) if a != b}
    if not len(nodes):
        reason = "local separators found none"
        return CurveSkeleton.empty(len(places.points), "local-separators", reason)
    gaps, owner = cKDTree(nodes).query(surface.points)
    count = np.maximum(np.bincount(owner, minlength=len(nodes)), 1)
    radii = np.bincount(owner, gaps, minlength=len(nodes)) / count
    edges = np.array(sorted(pairs), dtype=np.int64).reshape(-1, 2)
    reason = "" if len(edges) else "local separators found one node only"
    owners = owner.astype(np.int64)[places.index]
    return CurveSkeleton(nodes, edges, radii, owners, "local-separators", reason)


@contextmanager
def _quiet() -> Iterator[None]:
    """Without what the library, which is C++, prints about its progress."""
    sys.stdout.flush()
    kept = os.dup(1)
    try:
        with open(os.devnull, "w") as nowhere:
            os.dup2(nowhere.fileno(), 1)
            yield
    finally:
        os.dup2(kept, 1)
        os.close(kept)
