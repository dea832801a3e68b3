"""Isotropic remeshing of the built-in human: `remesh`, gpytoolbox and pymeshlab, as a Markdown table.

Each gets half of the marching-cubes surface, ended by the plane x = 0, and ten rounds. Wanted are edges as
long as the body plan asks for, no slivers, vertices on the surface, and a rim that stays in the plane,
where the mirror image joins. The other two take one edge length: the plan's away from its details.

Run: ``pip install gpytoolbox pymeshlab scs``, then ``python -m tests.benchmarks.remeshing``.
"""

import sys
import time

import numpy as np
from skimage.measure import marching_cubes

from datasets_gen.bodies import human
from datasets_gen.bodies.body_plan import Projector
from datasets_gen.meshes.remeshing import Edges, compact, remesh

ROUNDS = 10


def half_surface(plan):
    lower, upper = plan.surface.bounds()
    lower, upper = lower - 3 * plan.spacing, upper + 3 * plan.spacing
    lower[0] = 0.0
    axes = tuple(np.arange(lower[k], upper[k] + plan.spacing, plan.spacing) for k in range(3))
    field = plan.surface.on_grid(axes, far=4 * plan.spacing)
    field[np.abs(field) < 1e-6] = 1e-6
    nodes, faces, _, _ = marching_cubes(field, 0.0)
    return compact(nodes.astype(float) * plan.spacing + lower, faces.astype(np.int64))


def remeshed(plan, vertices, faces):
    return remesh(vertices, faces, plan.sizing, Projector(plan.surface), ROUNDS)


def botsch(plan, vertices, faces):
    import gpytoolbox

    return gpytoolbox.remesh_botsch(vertices, faces.astype(np.int32), ROUNDS, plan.edge)


def meshlab(plan, vertices, faces):
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, faces))
    meshes.meshing_isotropic_explicit_remeshing(iterations=ROUNDS, targetlen=pymeshlab.PureValue(plan.edge))
    return meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix().astype(np.int64)


def smallest_angles(vertices, faces):
    corners = vertices[faces]
    angles = []
    for k in range(3):
        a, b = corners[:, (k + 1) % 3] - corners[:, k], corners[:, (k + 2) % 3] - corners[:, k]
        angles.append(np.arctan2(np.linalg.norm(np.cross(a, b), axis=1), np.einsum("nd,nd->n", a, b)))
    return np.degrees(np.min(angles, axis=0))


def row(plan, vertices, faces):
    edges = Edges(faces)
    a, b = vertices[edges.ends[:, 0]], vertices[edges.ends[:, 1]]
    ratio = np.quantile(np.linalg.norm(a - b, axis=1) / plan.sizing((a + b) / 2), [0.01, 0.5, 0.99])
    angles = smallest_angles(vertices, faces)
    off = 1e3 * np.abs(plan.surface(vertices)).max()
    rim = 1e3 * np.abs(vertices[edges.boundary_vertices(len(vertices)), 0]).max()
    return [
        f"{len(vertices)}",
        " / ".join(f"{value:.2f}" for value in ratio),
        f"{angles.min():.1f} / {np.quantile(angles, 0.01):.1f}",
        f"{off:.2f}",
        f"{rim:.3f}",
    ]


def write(*cells):
    sys.stdout.write(f"| {' | '.join(cells)} |\n")
    sys.stdout.flush()


def main():
    plan = human.plan(0)
    start = half_surface(plan)
    angles = "least angle, its 1 % quantile"
    write("method", "vertices", "edge / wanted, 1 / 50 / 99 %", angles, "off the surface, mm", "rim, mm", "s")
    write(*["---"] * 7)
    for name, method in (("ours", remeshed), ("gpytoolbox", botsch), ("pymeshlab", meshlab)):
        began = time.perf_counter()
        try:
            found = method(plan, *start)
        except ImportError as error:
            write(name, str(error))
            continue
        seconds = time.perf_counter() - began
        write(name, *row(plan, *found), f"{seconds:.1f}")


if __name__ == "__main__":
    main()
