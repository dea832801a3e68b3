"""Eqs. 4-7 with the obvious savings only: what `medial.similarity` is measured against.

Pairs are culled by tangency and radius; the points of a ball are summed in random order until phi falls below
the cut-off.
"""

import numpy as np
from scipy.sparse import csr_array

from datasets_gen.compiled import compiled, ranges, run_tasks
from medial.similarity.candidate_ball import candidate_ball, columns, smallest_width
from medial.sparse import symmetric


def plain_similarity(points, normals, weights, sigma_e=5.0, sigma_t=0.7, cutoff=1e-6) -> csr_array:
    n = len(points)
    order = np.random.default_rng(0).permutation(n)
    cloud = (*columns(points[order]), *columns(normals[order]), weights[order])
    settings = (sigma_e, sigma_t, -np.log(cutoff), smallest_width(points))
    parts = run_tasks(_rows, [(*cloud, *settings, *span) for span in ranges(n, 64)])
    i, j, values = (np.concatenate([part[k] for part in parts]) for k in range(3))
    return symmetric(order[i], order[j], values, n)


@compiled(fastmath={"contract", "reassoc"})
def _rows(px, py, pz, nx, ny, nz, mass, sigma_e, sigma_t, budget, cap, start, stop):
    n, size, count = len(px), 1024, 0
    rows, cols, values = np.empty(size, np.int64), np.empty(size, np.int64), np.empty(size)
    for i in range(start, stop):
        for j in range(i + 1, n):
            cx, cy, cz, r, tangency = candidate_ball(px, py, pz, nx, ny, nz, i, j)
            tilt = 4.0 * max(2.0 - tangency, 0.0) / (sigma_t * sigma_t)
            if r <= 0.0 or r > cap or tilt > budget:
                continue
            most, scale, depth = sigma_e * np.sqrt(budget - tilt), 1 / (r * r), 0.0
            for m in range(n):
                ux, uy, uz = px[m] - cx, py[m] - cy, pz[m] - cz
                q = (ux * ux + uy * uy + uz * uz) * scale
                if q < 1:
                    depth += mass[m] * (1 - q * q)
                    if depth > most:
                        break
            if depth > most:
                continue
            if count == size:
                size *= 2
                rows = np.concatenate((rows, rows))
                cols = np.concatenate((cols, cols))
                values = np.concatenate((values, values))
            rows[count], cols[count] = i, j
            values[count] = np.exp(-((depth / sigma_e) ** 2) - tilt)
            count += 1
    return rows[:count].copy(), cols[:count].copy(), values[:count].copy()
