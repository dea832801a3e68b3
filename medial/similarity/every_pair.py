"""Eqs. 4-7 pair by pair in double precision: balls of any radius, and the plain form that is timed.

Pairs are discarded by tangency and radius. The points of a ball are summed in a random order, which fills a
ball that is not empty soon, until phi falls below the cut-off.
"""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled, grown, ranges, run_tasks
from medial.similarity.candidate_ball import candidate_ball, columns
from medial.similarity.emptiness import Settings
from medial.validation import OrientedCloud

ROWS_PER_TASK = 64
ROWS_AT_ONCE = 1024  # before survivors are collected: bounds the memory


def similar_among_all(
    cloud: OrientedCloud, settings: Settings, mass: NDArray[np.float64]
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.float64]]]:
    """Pairs of points whose similarity reaches the cut-off, and it (Eq. 7).

    Parameters
    ----------
    cloud
    settings
        Parameters of Eq. 7; the radius cap may be infinite.
    mass : (n,)
        How much each point counts in Eq. 5.

    Yields
    ------
    i, j : (pairs,) int64
        Every pair once.
    phi : (pairs,) float64
    """
    n = len(cloud)
    order = np.random.default_rng(0).permutation(n)
    arrays = (*columns(cloud.points[order]), *columns(cloud.normals[order]), mass[order], settings)
    for first, last in ranges(n, ROWS_AT_ONCE):
        spans = [(first + a, first + b) for a, b in ranges(last - first, ROWS_PER_TASK)]
        for rows, cols, values in run_tasks(_rows, [(*arrays, *span) for span in spans]):
            yield order[rows], order[cols], values


@compiled()
def _rows(
    px: Any, py: Any, pz: Any, nx: Any, ny: Any, nz: Any, mass: Any, settings: Any, start: int, stop: int
) -> Any:
    """Similar pairs i, j > i with i in [start, stop)."""
    n, count = len(px), 0
    rows, cols, values = np.empty(1024, np.int64), np.empty(1024, np.int64), np.empty(1024)
    for i in range(start, stop):
        for j in range(i + 1, n):
            cx, cy, cz, r, tangency = candidate_ball(px, py, pz, nx, ny, nz, i, j)
            tilt = 4.0 * max(2.0 - tangency, 0.0) / (settings.sigma_t * settings.sigma_t)
            if r <= 0.0 or r > settings.cap or tilt > settings.budget:
                continue
            most, scale, depth = settings.sigma_e * np.sqrt(settings.budget - tilt), 1 / (r * r), 0.0
            for m in range(n):
                ux, uy, uz = px[m] - cx, py[m] - cy, pz[m] - cz
                q = (ux * ux + uy * uy + uz * uz) * scale
                if q < 1:
                    depth += mass[m] * (1 - q * q)
                    if depth > most:
                        break
            value = np.exp(-((depth / settings.sigma_e) ** 2) - tilt)
            if depth > most or value < settings.cutoff:
                continue
            if count == len(rows):
                rows, cols, values = grown(rows), grown(cols), grown(values)
            rows[count], cols[count], values[count] = i, j, value
            count += 1
    return rows[:count].copy(), cols[:count].copy(), values[:count].copy()
