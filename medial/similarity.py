"""Medial similarity phi between all pairs of points (Eqs. 4-7)."""

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array, csr_array

from medial.ball import candidate_ball, columns, smallest_width
from medial.checks import check_cloud
from medial.compiled import compiled, ranges, run_tasks

ROWS_PER_TASK = 64


def similarity(
    points: NDArray[np.floating],
    normals: NDArray[np.floating],
    sigma_e: float = 5.0,
    sigma_t: float = 0.7,
    cutoff: float = 1e-6,
    *,
    r_cap: float | None = None,
    weights: NDArray[np.floating] | None = None,
) -> csr_array:
    """Medial similarity of all pairs of points (Eq. 7).

    Parameters
    ----------
    points, normals : (n, 3)
        The cloud and its outward unit normals.
    sigma_e, sigma_t
        Tolerance to points inside the ball (Eq. 5) and to tilt of the normals (Eq. 4).
    cutoff
        Smaller similarities are dropped.
    r_cap
        Largest radius of a candidate ball, in the units of `points`; by default the smallest PCA width of the
        cloud. Eq. 6 measures depth relative to r, so without a cap enormous balls look empty.
    weights : (n,), optional
        How much each point counts in Eq. 5; 1 by default, which is the paper's formula as written. See
        `medial.density_weights` for weights that make phi independent of the number of points.

    Returns
    -------
    (n, n) float64 csr_array
        Symmetric to the bit, zero diagonal.

    Raises
    ------
    InputError
        If the arrays are not an oriented cloud.
    """
    points, normals = check_cloud(points, normals)
    cap = smallest_width(points) if r_cap is None else float(r_cap)
    n = len(points)
    order = np.random.default_rng(0).permutation(n)
    mass = np.ones(n) if weights is None else np.asarray(weights, dtype=np.float64)
    cloud = (*columns(points[order]), *columns(normals[order]), np.ascontiguousarray(mass[order]))
    tasks = [(*cloud, start, stop, sigma_e, sigma_t, cutoff, cap) for start, stop in ranges(n, ROWS_PER_TASK)]
    parts = run_tasks(_rows, tasks)
    rows, cols, values = (np.concatenate([part[k] for part in parts]) for k in range(3))
    rows, cols = order[rows], order[cols]
    both = coo_array(
        (np.concatenate([values, values]), (np.concatenate([rows, cols]), np.concatenate([cols, rows]))),
        shape=(n, n),
    )
    return csr_array(both.tocsr())


@compiled(fastmath={"contract", "reassoc"})
def _rows(px, py, pz, nx, ny, nz, mass, start, stop, sigma_e, sigma_t, cutoff, cap):  # type: ignore[no-untyped-def]  # noqa: ANN001, ANN202
    """Pairs i < j with phi >= cutoff for start <= i < stop."""
    n = len(px)
    budget = -np.log(cutoff)
    smallest = 2.0 - budget * sigma_t * sigma_t / 4.0
    size = 1024
    count = 0
    rows = np.empty(size, np.int64)
    cols = np.empty(size, np.int64)
    values = np.empty(size, np.float64)
    for i in range(start, stop):
        for j in range(i + 1, n):
            cx, cy, cz, r, tangency = candidate_ball(px, py, pz, nx, ny, nz, i, j)
            if r <= 0.0 or r > cap or tangency < smallest:
                continue
            tilt = 4.0 * max(2.0 - tangency, 0.0) / (sigma_t * sigma_t)
            if tilt > budget:
                continue
            most = sigma_e * np.sqrt(budget - tilt)
            scale = 1.0 / (r * r)
            depth = 0.0
            for m in range(n):
                ux, uy, uz = px[m] - cx, py[m] - cy, pz[m] - cz
                q = (ux * ux + uy * uy + uz * uz) * scale
                if q < 1.0:
                    depth += mass[m] * (1.0 - q * q)
                    if depth > most:
                        break
            if depth > most:
                continue
            if count == size:
                size *= 2
                rows = np.concatenate((rows, np.empty(count, np.int64)))
                cols = np.concatenate((cols, np.empty(count, np.int64)))
                values = np.concatenate((values, np.empty(count, np.float64)))
            rows[count] = i
            cols[count] = j
            values[count] = np.exp(-((depth / sigma_e) ** 2) - tilt)
            count += 1
    return rows[:count].copy(), cols[:count].copy(), values[:count].copy()
