import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array
from scipy.sparse.csgraph import dijkstra

from datasets_gen import InputError
from evaluation.metrics.geodesic import SurfaceDistance
from evaluation.metrics.unfolding import face_adjacency
from tests.evaluation.meshes import as_shape, blob, plane, random_points, sphere


@pytest.fixture(scope="module")
def ball():
    shape = sphere(4)
    return shape, SurfaceDistance(shape)


def great_circle(shape, one, other):
    p, q = shape.at(*one), shape.at(*other)
    p /= np.linalg.norm(p, axis=1, keepdims=True)
    q /= np.linalg.norm(q, axis=1, keepdims=True)
    return np.arctan2(np.linalg.norm(np.cross(p, q), axis=1), np.einsum("nd,nd->n", p, q))


def test_sphere_against_great_circles(ball):
    shape, distance = ball
    one, other = random_points(shape, 500, 1), random_points(shape, 500, 2)
    relative = distance(*one, *other) / great_circle(shape, one, other) - 1
    assert abs(relative.mean()) < 0.006
    assert np.quantile(abs(relative), 0.99) < 0.02
    assert relative.min() > -0.01  # the mesh lies inside the sphere, so a little below is right


def test_plane_is_exact_where_lines_are_short_and_close_elsewhere():
    shape = plane()
    distance = SurfaceDistance(shape)
    one, other = random_points(shape, 400, 1), random_points(shape, 400, 2)
    true = np.linalg.norm(shape.at(*one) - shape.at(*other), axis=1)
    found = distance(*one, *other)
    assert (found >= true - 1e-12).all()
    assert (found / true).mean() < 1.005
    assert (found / true).max() < 1.04  # a coarse, irregular mesh
    near = true < 0.08  # about one edge: seen directly through the edges between
    assert near.any()
    assert np.allclose(found[near], true[near], rtol=1e-9)


def test_folding_a_flat_sheet_changes_nothing():
    flat = plane()
    x, y, _ = flat.vertices.T
    rolled = as_shape(np.column_stack([np.sin(x) * 1.0, y, np.cos(x)]), flat.faces)
    one, other = random_points(flat, 200, 1), random_points(flat, 200, 2)
    flat_distance = SurfaceDistance(flat)(*one, *other)
    assert np.allclose(SurfaceDistance(rolled)(*one, *other), flat_distance, rtol=0.01)


def brute_force(shape, one, other):
    """Dijkstra on the graph with the two points added as vertices."""
    from evaluation.metrics.unfolding import REACHED, enter

    d = SurfaceDistance(shape)
    v, ids, lengths = len(shape.vertices), np.empty(REACHED, np.int64), np.empty(REACHED)
    found = []
    for fp, bp, fq, bq in zip(*one, *other, strict=True):
        mesh = (d._vertices, d._faces, d._neighbour, d._opposite)
        used, direct = enter(*mesh, fp, bp, fq, bq, ids, lengths)
        entries = [(v, int(i), length) for i, length in zip(ids[:used], lengths[:used], strict=True)]
        used, _ = enter(*mesh, fq, bq, -1, np.zeros(3), ids, lengths)
        entries += [(int(i), v + 1, length) for i, length in zip(ids[:used], lengths[:used], strict=True)]
        best = {}
        for a, b, length in entries:
            best[a, b] = min(best.get((a, b), np.inf), length)
        coo = d.graph.tocoo()
        rows = np.concatenate([coo.coords[0], [a for a, _ in best]])
        cols = np.concatenate([coo.coords[1], [b for _, b in best]])
        graph = csr_array(
            (np.concatenate([coo.data, list(best.values())]), (rows, cols)), shape=(v + 2, v + 2)
        )
        found.append(min(direct, dijkstra(graph, indices=v)[v + 1]))
    return np.array(found)


@pytest.mark.parametrize("shape", [sphere(3), blob(3), plane()], ids=["sphere", "blob", "plane"])
def test_search_equals_dijkstra(shape):
    one, other = random_points(shape, 40, 3), random_points(shape, 40, 4)
    assert np.allclose(SurfaceDistance(shape)(*one, *other), brute_force(shape, one, other), rtol=1e-12)


BLOB = blob(3)
BLOB_DISTANCE = SurfaceDistance(BLOB)


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6))
def test_is_a_metric(seed):
    a, b, c = (random_points(BLOB, 3, [seed, k]) for k in range(3))
    ab, ba, bc, ac = (BLOB_DISTANCE(*p, *q) for p, q in ((a, b), (b, a), (b, c), (a, c)))
    assert np.allclose(ab, ba, rtol=1e-12)
    assert np.allclose(BLOB_DISTANCE(*a, *a), 0)
    assert (
        ac <= (ab + bc) * 1.02 + 1e-12
    ).all()  # the graph bends lines a little at points that are no vertices
    chord = np.linalg.norm(BLOB.at(*a) - BLOB.at(*b), axis=1)
    assert (ab >= chord - 1e-12).all()


def test_points_on_corners_and_edges(ball):
    shape, distance = ball
    corner = np.eye(3)[[0, 1, 2]]
    vertices = shape.faces[[0, 0, 0], [0, 1, 2]]
    expected = distance.from_vertices(vertices)
    far = np.array([500, 500, 500])
    found = distance(np.zeros(3, int), corner, far, np.eye(3)[[0, 0, 0]])
    assert np.allclose(found, expected[:, shape.faces[500, 0]], rtol=1e-12)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 10**6), st.integers(1, 60), st.booleans())
def test_nearest_of_a_set_is_the_least_of_the_pairs(seed, count, crowded):
    points, others = random_points(BLOB, 20, [seed, 0]), random_points(BLOB, count, [seed, 1])
    if crowded:  # many on few faces around one of the points: straight lines decide
        others = (others[0] % 8 + points[0][0] - 4).clip(0), others[1]
    i, j = (each.ravel() for each in np.indices((20, count)))
    pairs = BLOB_DISTANCE(points[0][i], points[1][i], others[0][j], others[1][j]).reshape(20, count)
    assert np.allclose(BLOB_DISTANCE.to_nearest(*points, *others), pairs.min(axis=1), rtol=1e-12, atol=1e-14)


def test_nearest_of_a_set_on_corners_and_out_of_reach():
    two = as_shape(
        np.vstack([sphere(1).vertices, sphere(1).vertices + 5]),
        np.vstack([sphere(1).faces, sphere(1).faces + 42]),
    )
    distance, centre = SurfaceDistance(two), np.full((2, 3), 1 / 3)
    corner = np.array([0]), np.eye(3)[[0]]
    found = distance.to_nearest(np.array([0, len(two.faces) - 1]), np.eye(3)[[0, 0]], *corner)
    assert found.tolist() == [0, np.inf]
    nothing = np.empty(0, int), np.empty((0, 3))
    assert np.isinf(distance.to_nearest(np.array([0, 1]), centre, *nothing)).all()


def test_separate_components_are_infinitely_far():
    two = as_shape(
        np.vstack([sphere(1).vertices, sphere(1).vertices + 5]),
        np.vstack([sphere(1).faces, sphere(1).faces + 42]),
    )
    first, last = np.array([0]), np.array([len(two.faces) - 1])
    centre = np.full((1, 3), 1 / 3)
    assert np.isinf(SurfaceDistance(two)(first, centre, last, centre)).all()
    assert np.isfinite(SurfaceDistance(two)(first, centre, first + 7, centre)).all()


def test_adjacency_refuses_what_is_no_oriented_manifold():
    with pytest.raises(InputError, match="more than two faces"):
        face_adjacency(np.array([[0, 1, 2], [0, 1, 3]]))  # the edge 0-1 runs the same way twice
