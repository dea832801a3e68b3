"""Milliseconds to find nearest points and normals: the matcher's tree of boxes, and scipy's tree.

python -m tests.benchmarks.place_tree
"""

import sys
import time

import numpy as np
from scipy.spatial import cKDTree

from medial.matching.registration.closest_points import PlaceTree
from medial.matching.registration.registration import features
from tests.medial.posed import figure

GOALS, REPEATS = 500, 20


def least_milliseconds(function):
    times = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        function()
        times.append(time.perf_counter() - begin)
    return 1000 * min(times)


def main():
    for count in (2000, 8000, 20000):
        cloud = figure(count)
        places = features(cloud.points / np.sqrt(cloud.areas.sum()), cloud.normals)
        random = np.random.default_rng(0)
        goals = places[random.permutation(count)[:GOALS]] + 0.02 * random.standard_normal((GOALS, 6))
        ours, scipy = PlaceTree(places), cKDTree(places)
        assert np.array_equal(ours.nearest(goals), scipy.query(goals)[1])
        times = (
            least_milliseconds(lambda places=places: PlaceTree(places)),
            least_milliseconds(lambda places=places: cKDTree(places)),
            least_milliseconds(lambda ours=ours, goals=goals: ours.nearest(goals)),
            least_milliseconds(lambda scipy=scipy, goals=goals: scipy.query(goals)),
        )
        words = "{} places: made in {:.2f} ms (scipy {:.2f}), {} found in {:.2f} ms ({:.2f})\n"
        sys.stdout.write(words.format(count, *times[:2], GOALS, *times[2:]))


if __name__ == "__main__":
    main()
