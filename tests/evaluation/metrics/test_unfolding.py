"""Straight lines over unfolded triangles against the plane, where they are straight lines."""

import numpy as np
import pytest
from scipy.spatial import Delaunay

from datasets_gen import InputError
from evaluation.metrics import unfolding
from evaluation.metrics.unfolding import DEPTH, ENTRY_DEPTH, REACHED, enter, face_adjacency, shortcuts

pytestmark = pytest.mark.uncompiled

RANDOM = np.random.default_rng(5)
TURN = np.linalg.qr(RANDOM.normal(size=(3, 3)))[0]


def side(p, q, r):
    return (q[0] - p[0]) * (r[1] - p[1]) - (q[1] - p[1]) * (r[0] - p[0])


def sheet(count=40):
    """Random points of the plane, triangulated counter-clockwise; every line between them stays inside."""
    flat = np.random.default_rng(0).uniform(size=(count, 2)) * [2.0, 1]
    faces = Delaunay(flat).simplices.astype(np.int64)
    a, b, c = (flat[faces[:, k]] for k in range(3))
    turned = side(a.T, b.T, c.T) < 0
    faces[turned] = faces[turned][:, ::-1]
    return flat, faces


FLAT, FACES = sheet()
VERTICES = np.column_stack([FLAT, np.zeros(len(FLAT))]) @ TURN.T + 3
MESH = (VERTICES, FACES, *face_adjacency(FACES))
EDGES = sorted({tuple(sorted((f[k], f[k - 1]))) for f in FACES for k in range(3)})


def crossed(p, q, ends=()):
    """Edges that a line crosses, those at its own ends left out."""
    return sum(
        side(p, q, FLAT[a]) * side(p, q, FLAT[b]) < 0
        and side(FLAT[a], FLAT[b], p) * side(FLAT[a], FLAT[b], q) < 0
        for a, b in EDGES
        if a not in ends and b not in ends
    )


def inside(face, weights):
    return weights @ FLAT[FACES[face]]


def test_neighbours_share_an_edge_that_lies_opposite_both_corners():
    neighbour, opposite = face_adjacency(FACES)
    for f, face in enumerate(FACES):
        for k in range(3):
            edge = {face[(k + 1) % 3], face[(k + 2) % 3]}
            others = [g for g in range(len(FACES)) if g != f and edge <= set(FACES[g])]
            assert neighbour[f, k] == (others[0] if others else -1)
            if others:
                assert {FACES[others[0]][opposite[f, k]]} == set(FACES[others[0]]) - edge
            else:
                assert opposite[f, k] == 0


@pytest.mark.parametrize("faces", [[[0, 1, 2], [0, 1, 3]], [[0, 1, 2], [1, 0, 3], [1, 0, 4]]])
def test_mixed_orientation_and_edges_of_three_faces_are_refused(faces):
    with pytest.raises(InputError, match="more than two faces or mixed orientation"):
        face_adjacency(np.array(faces))


def test_third_corner_is_where_both_distances_say():
    """The corner lies beyond the edge, seen from the origin."""
    for _ in range(50):
        right, left = RANDOM.uniform(0.5, 1.5, 2) * [1, -0.5], RANDOM.uniform(0.5, 1.5, 2)
        edge = left - right
        away = np.array([edge[1], -edge[0]])  # to the right of the way from the right end to the left one
        corner = right + RANDOM.uniform(-0.5, 1.5) * edge + RANDOM.uniform(0.1, 1) * away
        to_right, to_left = np.linalg.norm(corner - right), np.linalg.norm(corner - left)
        assert unfolding.third_corner(*right, *left, to_right, to_left) == pytest.approx(tuple(corner))


def test_third_corner_of_a_triangle_without_height_is_on_the_edge():
    """Rounding may leave the two sides shorter than the edge."""
    assert unfolding.third_corner(1.0, 0.0, 1.0, 2.0, 0.5, 1.5 - 1e-9) == pytest.approx((1.0, 0.5), abs=1e-4)


def test_a_triangle_is_laid_flat_about_a_point_of_it():
    for _ in range(20):
        corners, weights = RANDOM.normal(size=(3, 3)), RANDOM.dirichlet([1, 1, 1])
        vertices, point = np.vstack([np.zeros((2, 3)), corners]), weights @ corners
        flat = unfolding.lay_flat(vertices, 2, 3, 4, point)
        assert weights @ flat == pytest.approx(np.zeros(2), abs=1e-12)
        assert np.linalg.norm(flat, axis=1) == pytest.approx(np.linalg.norm(corners - point, axis=1))
        for k in range(3):
            length = np.linalg.norm(corners[k] - corners[k - 1])
            assert np.linalg.norm(flat[k] - flat[k - 1]) == pytest.approx(length)
            assert unfolding._length(vertices, 2 + k, 2 + (k - 1) % 3) == pytest.approx(length)
        assert side(*flat) > 0


def entered(face, weights, goal_face=-1, goal=(0.0, 0, 0)):
    ids, lengths = np.empty(REACHED, np.int64), np.empty(REACHED)
    used, direct = enter(*MESH, face, weights, goal_face, np.array(goal), ids, lengths)
    return ids[:used].tolist(), lengths[:used], direct


def test_a_point_sees_each_vertex_beyond_few_edges_once_at_its_distance():
    """In a plane all lines are free; of them those count that cross at most `ENTRY_DEPTH` edges."""
    beyond = 0
    for face in range(0, len(FACES), 6):
        weights = RANDOM.dirichlet([2, 2, 2])
        here = inside(face, weights)
        between = np.array([crossed(here, FLAT[v], (v,)) for v in range(len(FLAT))])
        ids, lengths, direct = entered(face, weights)
        assert sorted(ids) == np.flatnonzero(between <= ENTRY_DEPTH).tolist()
        assert lengths == pytest.approx(np.linalg.norm(FLAT[ids] - here, axis=1))
        assert direct == np.inf
        beyond += (between > ENTRY_DEPTH).sum()
    assert beyond > 20


def test_a_point_sees_another_one_beyond_few_edges():
    seen, hidden = 0, 0
    for _ in range(60):
        (face, goal_face), (weights, goal) = (
            RANDOM.integers(len(FACES), size=2),
            RANDOM.dirichlet([2, 2, 2], 2),
        )
        here, there = inside(face, weights), inside(goal_face, goal)
        direct = entered(face, weights, goal_face, goal)[2]
        if crossed(here, there) <= ENTRY_DEPTH:
            assert direct == pytest.approx(np.linalg.norm(here - there))
            seen += 1
        else:
            assert direct == np.inf
            hidden += 1
    assert min(seen, hidden) > 10
    one, other = RANDOM.dirichlet([1, 1, 1], 2)
    assert entered(3, one, 3, other)[2] == pytest.approx(np.linalg.norm(inside(3, one) - inside(3, other)))


def test_shortcuts_are_all_lines_between_vertices_beyond_few_edges():
    rows, cols, lengths = shortcuts(*MESH)
    assert lengths == pytest.approx(np.linalg.norm(FLAT[rows] - FLAT[cols], axis=1))
    found = {tuple(sorted(pair)) for pair in zip(rows.tolist(), cols.tolist(), strict=True)}
    n = len(FLAT)
    few = {(a, b) for a in range(n) for b in range(a + 1, n) if crossed(FLAT[a], FLAT[b], (a, b)) <= DEPTH}
    assert found == few
    assert len(few) < n * (n - 1) / 2


def folded(angle):
    """Two triangles hinged at the edge from (0, 0, 0) to (0, 1, 0)."""
    vertices = np.array([[0.0, 0, 0], [0, 1, 0], [-1, 0.3, 0], [np.cos(angle), 0.6, np.sin(angle)]])
    faces = np.array([[0, 1, 2], [1, 0, 3]])
    return vertices, faces, *face_adjacency(faces)


@pytest.mark.parametrize("angle", [0.0, 1.0, 3.0])
def test_folding_changes_no_way_on_the_surface(angle):
    """Corners at (-1, 0.3) and (1, 0.6) of the unfolded sheet."""
    mesh = folded(angle)
    ids, lengths = np.empty(REACHED, np.int64), np.empty(REACHED)
    weights, goal = np.array([0.2, 0.3, 0.5]), np.array([0.1, 0.5, 0.4])
    here, there = np.array([-0.5, 0.3 + 0.15]), np.array([0.4, 0.1 + 0.24])
    used, direct = enter(*mesh, 0, weights, 1, goal, ids, lengths)
    places = np.array([[0, 0], [0, 1], [-1, 0.3], [1, 0.6]])
    assert ids[:used].tolist() == [0, 1, 2, 3]
    assert lengths[:used] == pytest.approx(np.linalg.norm(places - here, axis=1))
    assert direct == pytest.approx(np.linalg.norm(here - there))
    rows, cols, lengths = shortcuts(*mesh)
    assert lengths[(rows == 2) & (cols == 3)] == pytest.approx([np.hypot(2, 0.3)])


def test_a_corner_behind_an_edge_is_not_seen():
    """Seen from (-1, 0), a corner at (1, 3) lies outside the cone through the edge from (0, 0) to (0, 1)."""
    vertices = np.array([[0.0, 0, 0], [0, 1, 0], [-1, 0, 0], [1, 3, 0], [1, -1, 0], [0.5, 0.2, 0]])
    for far, seen in ((3, False), (4, False), (5, True)):
        faces = np.array([[0, 1, 2], [1, 0, far]])
        rows, cols, _ = shortcuts(vertices, faces, *face_adjacency(faces))
        assert ((rows == 2) & (cols == far)).any() == seen
        assert ((rows == far) & (cols == 2)).any() == seen
