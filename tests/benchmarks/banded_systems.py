"""Seconds to solve the normal equations of a deformation graph: envelope, banded and dense Cholesky.

python -m tests.benchmarks.banded_systems
"""

import sys
import time

import numpy as np
from scipy.linalg import cho_factor, cho_solve, solveh_banded

from medial.matching.neighbourhoods import neighbourhoods
from medial.matching.registration.deformation_graph import NodeGraph, Pose
from medial.matching.registration.energy_terms import add_points
from medial.matching.registration.envelope import cholesky_solve
from tests.medial.posed import figure

REPEATS = 20


def system_of(nodes):
    """Normal equations of the figure at rest, every point pulled evenly."""
    cloud = figure(3000)
    points = cloud.points / np.sqrt(cloud.areas.sum())
    graph, hang = NodeGraph.over(neighbourhoods(cloud), points, np.arange(len(points)), nodes)
    pose = Pose(np.tile(np.eye(3), (len(graph), 1, 1)), graph.rest.copy())
    envelope, right = graph.envelope, np.zeros(6 * len(graph))
    values = envelope.zeros()
    metric = np.tile(np.eye(3) / len(points), (len(points), 1, 1))
    force = np.random.default_rng(0).standard_normal((len(points), 3)) / len(points)
    here = points, hang.nodes, hang.weights, graph.rest, pose.rotations
    add_points(values, envelope.origin, right, *here, metric, force)
    graph.add_edges(values, right, pose, 0.1)
    diagonal = envelope.diagonal
    values[diagonal] += 1e-6 * values[diagonal].sum() / len(diagonal)
    return envelope, values, right


def as_band(system):
    """The diagonals of the lower triangle, as many as the widest row has."""
    rows, columns = np.nonzero(np.tril(system))
    band = np.zeros((int((rows - columns).max()) + 1, len(system)))
    band[rows - columns, columns] = system[rows, columns]
    return band


def enveloped(envelope):
    return lambda values, right: cholesky_solve(values, right, envelope.first, envelope.origin)


def banded(band, right):
    return solveh_banded(band, right, lower=True, check_finite=False)


def dense(system, right):
    return cho_solve(cho_factor(system, lower=True, check_finite=False), right, check_finite=False)


def main():
    for nodes in (80, 200):
        envelope, values, right = system_of(nodes)
        system = envelope.dense(values)
        exact = dense(system, right)
        rows, columns = np.nonzero(np.tril(system))
        starts = np.zeros(len(system))
        np.maximum.at(starts, rows, rows - columns)
        sys.stdout.write(
            f"{len(system)} unknowns, bands of {starts.mean():.0f} (mean) to {starts.max():.0f}\n"
        )
        band = as_band(system)  # its time does not count
        for name, solve, given in (
            ("ours", enveloped(envelope), values),
            ("solveh_banded", banded, band),
            ("dense", dense, system),
        ):
            solve(given.copy(), right)
            copies = [given.copy() for _ in range(REPEATS)]
            begin = time.perf_counter()
            for each in copies:
                found = solve(each, right)
            seconds = (time.perf_counter() - begin) / REPEATS
            error = np.abs(found - exact).max() / np.abs(exact).max()
            sys.stdout.write(f"  {name:<14}{1000 * seconds:7.2f} ms   differs by {error:.0e}\n")


if __name__ == "__main__":
    main()
