"""Pictures of clouds: discs in tangent planes against Mitsuba's spheres, on one cloud at one size."""

import numpy as np
import pytest

from reports.figures.point_renderer import fitted_cameras, look_from, render_points
from scanner_sim.tracing import variant

POINTS, HEIGHT = 5000, 420


@pytest.fixture(scope="module")
def cloud():
    normals = np.random.default_rng(0).normal(size=(POINTS, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return normals * [0.4, 1.0, 0.3], normals, np.abs(normals)


def test_discs(benchmark, cloud):
    points, normals, colors = cloud
    camera = fitted_cameras([points], look_from(25), HEIGHT)[0]
    image = benchmark(render_points, points, normals, colors, camera)
    assert image.shape[0] == HEIGHT


def test_mitsuba_spheres(benchmark, cloud, tmp_path):
    points, _, colors = cloud
    with variant.active(variant.SCALAR) as mi:
        image = benchmark.pedantic(spheres, (mi, points, colors, tmp_path / "spheres.ply"), rounds=3)
    assert image.shape[0] == HEIGHT


def spheres(mi, points, colors, path):
    """Render a mesh of one small sphere per point, with colours at its vertices."""
    import trimesh

    ball = trimesh.creation.icosphere(subdivisions=1, radius=0.01)
    count = len(ball.vertices)
    vertices = (points[:, None] + ball.vertices).reshape(-1, 3)
    faces = (ball.faces + count * np.arange(len(points))[:, None, None]).reshape(-1, 3)
    table = np.hstack(
        [vertices, np.tile(ball.vertices * 100, (len(points), 1)), np.repeat(colors, count, axis=0)]
    )
    rows = np.empty(len(faces), dtype=[("n", "u1"), ("ids", "<i4", 3)])
    rows["n"], rows["ids"] = 3, faces
    names = "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz", "r", "g", "b"))
    head = f"ply\nformat binary_little_endian 1.0\nelement vertex {len(table)}\n{names}"
    head += f"element face {len(faces)}\nproperty list uchar int vertex_indices\nend_header\n"
    path.write_bytes(head.encode() + table.astype("<f4").tobytes() + rows.tobytes())
    view = mi.ScalarTransform4f().look_at([0, 0, 5], [0, 0, 0], [0, 1, 0])
    film = {"type": "hdrfilm", "width": 250, "height": HEIGHT}
    sensor = {"type": "perspective", "fov": 20, "to_world": view, "film": film}
    sensor["sampler"] = {"type": "independent", "sample_count": 16}
    color = {"type": "mesh_attribute", "name": "vertex_color"}
    shape = {"type": "ply", "filename": str(path), "bsdf": {"type": "diffuse", "reflectance": color}}
    scene = {"type": "scene", "integrator": {"type": "direct"}, "sensor": sensor, "shape": shape}
    return np.array(mi.render(mi.load_dict({**scene, "light": {"type": "constant"}})))
