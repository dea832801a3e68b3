"""What set-up compiles is what a run uses."""

import numpy as np

from evaluation.compile_metrics import warm_up
from evaluation.metrics import geodesic, nearest_place
from evaluation.metrics.geodesic import SurfaceDistance
from evaluation.running.read_only import read_only
from scanner_sim import sample
from tests.evaluation.meshes import blob


def test_distances_in_a_sweep_use_the_kernels_that_were_compiled():
    kernels = [geodesic._pairs, geodesic.shortcuts, nearest_place.straight_lines]
    warm_up()
    compiled = [list(kernel.signatures) for kernel in kernels]
    assert all(compiled)
    free, locked = blob(2), read_only(blob(2))
    for body in (free, locked):
        distance, scan = SurfaceDistance(body), sample(body, 20, seed=0)
        for points in (scan, read_only(scan)):
            half = [
                points.face_ids[:10],
                points.barycentrics[:10],
                points.face_ids[10:],
                points.barycentrics[10:],
            ]
            assert np.isfinite(distance(*half)).all()
            assert np.isfinite(distance.to_nearest(*half)).all()
    assert [list(kernel.signatures) for kernel in kernels] == compiled
