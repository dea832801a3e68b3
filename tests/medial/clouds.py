"""Oriented clouds with known geometry: points and outward normals lie exactly on the surface."""

import fpsample
import numpy as np

LIMBS = (  # start, end, radius at the start and at the end
    ((0, 0, -0.35), (0, 0, 0.35), 0.30, 0.26),
    ((0, 0, 0.35), (0.05, 0, 0.85), 0.13, 0.17),
    ((0.15, 0, 0.3), (0.95, 0.1, 0.5), 0.12, 0.07),
    ((-0.15, 0, 0.3), (-0.8, 0.3, 0.0), 0.12, 0.08),
    ((0.1, 0, -0.4), (0.25, 0.1, -1.2), 0.16, 0.09),
    ((-0.1, 0, -0.4), (-0.35, -0.2, -1.15), 0.16, 0.09),
)


def sphere(n, radius=1.0):
    """Fibonacci sphere: nearly equal areas, no symmetry between points."""
    k = np.arange(n) + 0.5
    polar, turn = np.arccos(1 - 2 * k / n), np.pi * (1 + 5**0.5) * k
    normals = np.stack([np.cos(turn) * np.sin(polar), np.sin(turn) * np.sin(polar), np.cos(polar)], axis=1)
    return radius * normals, normals


def cylinder(n, radius=0.3, length=2.0, seed=0):
    """Open cylinder about the z axis, farthest-point sampled."""
    random = np.random.default_rng(seed)
    turn, z = random.uniform(0, 2 * np.pi, 12 * n), random.uniform(-length / 2, length / 2, 12 * n)
    normals = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], axis=1)
    points = radius * normals + z[:, None] * [0, 0, 1]
    return thinned(points, normals, n)


def torus(n, large=1.0, small=0.3, seed=0):
    random = np.random.default_rng(seed)
    u, v = random.uniform(0, 2 * np.pi, (2, 12 * n))
    kept = random.uniform(size=12 * n) < (large + small * np.cos(v)) / (large + small)
    u, v = u[kept], v[kept]
    normals = np.stack([np.cos(u) * np.cos(v), np.sin(u) * np.cos(v), np.sin(v)], axis=1)
    ring = np.stack([np.cos(u), np.sin(u), np.zeros_like(u)], axis=1)
    return thinned(large * ring + small * normals, normals, n)


def planes(n, gap=0.2, seed=0):
    """The two faces of a plate of side 1, seen from outside."""
    random = np.random.default_rng(seed)
    points = np.column_stack([random.uniform(size=(6 * n, 2)), np.repeat([-gap / 2, gap / 2], 3 * n)])
    normals = np.zeros_like(points)
    normals[:, 2] = np.sign(points[:, 2])
    return thinned(points, normals, n)


def body(n, seed=0, holes=0, bare=0.22):
    """A figure with a head and four unequal limbs: smooth union of cones; `holes` balls of it are missing."""
    random = np.random.default_rng(seed)
    points = []
    for start, end, thick, thin in LIMBS:
        a, b = np.asarray(start, float), np.asarray(end, float)
        share = random.uniform(-0.15, 1.15, 4 * n)
        direction = random.standard_normal((4 * n, 3))
        radii = (thick + np.clip(share, 0, 1) * (thin - thick))[:, None]
        points.append(
            a + share[:, None] * (b - a) + radii * direction / np.linalg.norm(direction, axis=1)[:, None]
        )
    points = np.concatenate(points)
    for _ in range(12):
        value, gradient = _union(points)
        points = points - np.clip(value, -0.1, 0.1)[:, None] * gradient / (gradient**2).sum(
            axis=1, keepdims=True
        )
    value, gradient = _union(points)
    good = np.abs(value) < 1e-9
    points, normals = points[good], gradient[good] / np.linalg.norm(gradient[good], axis=1, keepdims=True)
    for center in points[np.random.default_rng(7).integers(len(points), size=holes)]:
        kept = np.linalg.norm(points - center, axis=1) > bare
        points, normals = points[kept], normals[kept]
    return thinned(points, normals, n)


def thinned(points, normals, n):
    chosen = fpsample.bucket_fps_kdline_sampling(points.astype(np.float32), n, h=6, start_idx=0)
    return points[chosen].astype(np.float64), normals[chosen].astype(np.float64)


def _union(points, sharpness=18.0):
    """Smooth union of the limbs, negative inside, and its gradient."""
    total, gradient = np.zeros(len(points)), np.zeros_like(points)
    for start, end, thick, thin in LIMBS:
        a, b = np.asarray(start, float), np.asarray(end, float)
        axis = b - a
        share = (points - a) @ axis / (axis @ axis)
        inside = (share > 0) & (share < 1)
        offset = points - a - np.clip(share, 0, 1)[:, None] * axis
        distance = np.linalg.norm(offset, axis=1)
        value = np.exp(-sharpness * (distance - thick - np.clip(share, 0, 1) * (thin - thick)))
        slope = offset / distance[:, None] - inside[:, None] * (thin - thick) * axis / (axis @ axis)
        total += value
        gradient += value[:, None] * slope
    return -np.log(total) / sharpness, gradient / total[:, None]


def rotation(seed=0):
    q, r = np.linalg.qr(np.random.default_rng(seed).standard_normal((3, 3)))
    q = q * np.sign(np.diag(r))
    return q * np.sign(np.linalg.det(q))


def random_cloud(n, seed=0):
    """Nothing to bound: positions and normals at random."""
    points, normals = np.random.default_rng(seed).normal(size=(2, n, 3))
    return points, normals / np.linalg.norm(normals, axis=1, keepdims=True)
