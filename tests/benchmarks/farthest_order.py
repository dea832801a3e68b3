"""Farthest points of a cloud by fpsample and by our own function, from one start: same points, seconds.

python -m tests.benchmarks.farthest_order [POINTS] [COUNT]
"""

import sys
import time

import numpy as np

from datasets_gen.points.farthest import farthest_in_embedding, farthest_points


def timed(function, *arguments):
    function(*arguments)
    start = time.perf_counter()
    return function(*arguments), time.perf_counter() - start


def main(points, count):
    """A noisy sphere stands for a scan."""
    random = np.random.default_rng(0)
    cloud = random.standard_normal((points, 3))
    cloud *= (1 + 0.01 * random.standard_normal((points, 1))) / np.linalg.norm(cloud, axis=1, keepdims=True)
    theirs, fast = timed(farthest_points, cloud, count, 0)
    ours, slow = timed(farthest_in_embedding, cloud, count, int(theirs[0]))
    first = int(np.argmax(theirs != ours)) if (theirs != ours).any() else count
    common = len(np.intersect1d(theirs, ours))
    sys.stdout.write(
        f"{count} of {points} points: fpsample {fast:.3f} s, ours {slow:.3f} s; "
        f"the first {first} in the same order, {common} in common\n"
    )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 30_000, int(sys.argv[2]) if len(sys.argv) > 2 else 5000)
