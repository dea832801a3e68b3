"""Compile the kernels of distances on surfaces once: ``python -m evaluation.compile_metrics``.

`medial.precompile` does the same for the operator and the matcher. What is left is compiled where it is first
used, in a second or two.
"""

import numpy as np

from datasets_gen import Shape, load
from evaluation.metrics.correspondence import SurfacePoints, correspondence_error, least_errors
from evaluation.metrics.geodesic import SurfaceDistance
from evaluation.metrics.limbs import find_limbs
from scanner_sim import sample

POINTS = 50


def warm_up() -> None:
    """Measure a map of a few points of the smallest built-in body, and find its limbs."""
    body: Shape = load("dumbbell").reference
    distance = SurfaceDistance(body)
    find_limbs(body, distance)
    scan = sample(body, POINTS, seed=0)
    points = SurfacePoints(scan.face_ids, scan.barycentrics)
    correspondence_error(distance, points, points, np.arange(POINTS)[::-1], body.area)
    least_errors(distance, points, points, body.area)


if __name__ == "__main__":
    warm_up()
