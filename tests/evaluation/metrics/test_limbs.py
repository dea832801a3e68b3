import numpy as np
import pytest

from datasets_gen import load
from evaluation.metrics.correspondence import SurfacePoints
from evaluation.metrics.geodesic import SurfaceDistance
from evaluation.metrics.limbs import LEAST, Limbs, _edges, find_limbs, limb_shares, remoteness
from evaluation.metrics.mirror_images import mirror_points
from tests.evaluation.meshes import as_shape, random_points, sphere

HUMAN = {  # place of the tip: what is there
    (0.66, 0.89, 0.0): "arm.L", (-0.66, 0.89, 0.0): "arm.R", (0.13, 0.01, 0.17): "leg.L",
    (-0.13, 0.01, 0.17): "leg.R", (0.0, 1.75, 0.01): "head",
}  # fmt: skip
QUADRUPED = {
    (0.14, 0.01, 0.41): "fore.L", (-0.14, 0.01, 0.41): "fore.R", (0.14, 0.01, -0.55): "hind.L",
    (-0.14, 0.01, -0.55): "hind.R", (0.0, 1.59, 1.36): "head", (0.0, 0.62, -0.96): "tail",
}  # fmt: skip
ACROSS = {"L": "R", "R": "L"}


@pytest.fixture(scope="module", params=["human", "quadruped"])
def body(request):
    """A collection, its limbs, and their names by limb."""
    collection = load(request.param)
    shape = collection.reference
    limbs = find_limbs(shape, SurfaceDistance(shape), collection.mirror)
    known = HUMAN if request.param == "human" else QUADRUPED
    gaps = np.linalg.norm(shape.vertices[limbs.tips][:, None] - np.array(list(known))[None], axis=2)
    assert (gaps.min(axis=1) < 0.05).all()
    return collection, limbs, [list(known.values())[k] for k in gaps.argmin(axis=1)], len(known)


def test_built_in_bodies_have_the_limbs_that_people_see(body):
    collection, limbs, names, count = body
    assert len(limbs) == count == len(set(names))
    for limb, name in enumerate(names):
        stem, _, side = name.partition(".")
        assert names[limbs.mirror[limb]] == (f"{stem}.{ACROSS[side]}" if side else name)
        x = collection.reference.vertices[limbs.of_vertex == limb, 0]
        assert (x * {"L": 1, "R": -1}.get(side, 0) >= -0.01).all()
    assert 0.1 < (limbs.of_vertex == -1).mean() < 0.5


def shares(body, image, source, target):
    collection, limbs = body[:2]
    here, shown = (limbs.of_points(collection.reference, each) for each in (source, target))
    return limb_shares(here, np.where(image >= 0, shown[image], -1), shown, limbs.mirror)


def test_the_true_map_takes_every_limb_to_itself_and_the_mirrored_one_each_of_a_pair_to_the_other(body):
    collection, _, names, _ = body
    cloud = SurfacePoints(*random_points(collection.reference, 2000))
    mirrored = mirror_points(collection.reference, collection.mirror, cloud)
    itself = np.arange(len(cloud))
    assert shares(body, itself, cloud, cloud) == (1, 0)
    alone = sum("." not in name for name in names) / len(names)  # head and tail stay where they are
    assert shares(body, itself, cloud, mirrored) == (pytest.approx(alone), 1)
    assert shares(body, np.full(len(cloud), -1), cloud, cloud) == (0, 0)


def test_limbs_that_were_not_scanned_do_not_count(body):
    collection, limbs = body[:2]
    cloud = SurfacePoints(*random_points(collection.reference, 2000))
    limb = limbs.of_points(collection.reference, cloud)
    left = cloud[limb != 0]
    wrong = np.zeros(len(left), int)  # all to one place, on a limb or not
    place = limbs.of_points(collection.reference, left)[0]
    right, _ = shares(body, wrong, left, left)
    assert right == pytest.approx(float(place >= 0) / (len(limbs) - 1))
    trunk = cloud[limb == -1]
    assert shares(body, np.arange(len(trunk)), trunk, trunk) == (None, None)


def test_shares_by_hand():
    here = np.repeat([0, 1, 2, 3, -1], [LEAST, LEAST, LEAST, LEAST - 1, 5])
    there = here.copy()
    there[:LEAST] = 1  # limb 0 to its mirror image
    there[LEAST : LEAST + LEAST // 2] = -1  # just half of limb 1 is right: not most of it
    mirror = np.array([1, 0, 2, -1])
    assert limb_shares(here, there, here, mirror) == (pytest.approx(1 / 3), pytest.approx(1 / 2))
    assert limb_shares(here, there, here, None) == (pytest.approx(1 / 3), None)
    shown = here[here != 1]
    assert limb_shares(here, there, shown, mirror) == (pytest.approx(1 / 2), None)


def test_a_ball_has_no_limbs():
    ball = sphere(3)
    assert len(find_limbs(ball, SurfaceDistance(ball))) == 0


def test_limbs_do_not_depend_on_units_or_pose_in_space():
    shape = load("human").reference
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    moved = as_shape(1000 * shape.vertices @ turn.T + 5, shape.faces)
    one, other = (find_limbs(each, SurfaceDistance(each)).of_vertex for each in (shape, moved))
    assert (one == other).mean() > 0.99


class GivenDistance:
    """Any matrix of distances between vertices."""

    def __init__(self, matrix):
        self._matrix = matrix

    def from_vertices(self, sources):
        return self._matrix[sources]


def along_edges(shape):
    """Lengths of the shortest ways along edges, by Floyd and Warshall's loop."""
    n = len(shape.vertices)
    lengths = np.where(np.eye(n, dtype=bool), 0.0, np.inf)
    for face in shape.faces:
        for a, b in ((face[0], face[1]), (face[1], face[2]), (face[2], face[0])):
            lengths[a, b] = lengths[b, a] = np.linalg.norm(shape.vertices[a] - shape.vertices[b])
    for k in range(n):
        lengths = np.minimum(lengths, lengths[:, [k]] + lengths[[k]])
    return lengths


def cross(arms=(5, 4, 3), cell=1.0):
    """Flat squares: a middle one and arms to the right, up and to the left; and a vertex of no face."""
    squares = [(0, 0)]
    for (dx, dy), length in zip([(1, 0), (0, 1), (-1, 0)], arms, strict=False):
        squares += [(k * dx, k * dy) for k in range(1, length + 1)]
    corners = sorted({(x + i, y + j) for x, y in squares for i in (0, 1) for j in (0, 1)})
    number = {corner: k for k, corner in enumerate(corners)}
    faces = []
    for x, y in squares:
        a, b, c, d = (number[x + i, y + j] for i, j in ((0, 0), (1, 0), (1, 1), (0, 1)))
        faces += [[a, b, c], [a, c, d]]
    vertices = cell * np.column_stack([np.array(corners, float), np.zeros(len(corners))])
    return as_shape(np.vstack([vertices, [[90.0, 0, 0]]]), faces)


@pytest.mark.parametrize("bend", [0.0, 0.3])
def test_remoteness_of_a_small_body_by_loops(bend):
    """The mean distance over the area, of which every vertex stands for a third of its faces'."""
    shape = cross()
    x, y, z = shape.vertices.T
    shape = as_shape(np.column_stack([x + bend * x * np.abs(x), y, z]), shape.faces)  # squares of other sizes
    lengths, n = along_edges(shape), len(shape.vertices)
    area = np.zeros(n)
    for face in shape.faces:
        a, b, c = shape.vertices[face]
        for vertex in face:
            area[vertex] += np.linalg.norm(np.cross(b - a, c - a)) / 2 / 3
    expected = [sum(area[w] * lengths[v, w] for w in range(n - 1)) / sum(area) for v in range(n - 1)]
    found = remoteness(shape, GivenDistance(lengths))
    assert found[:-1] == pytest.approx(expected)
    assert found[-1] == 0


def test_remoteness_of_two_small_pieces_is_that_within_each():
    one = cross((2, 1))
    n = len(one.vertices)
    both = as_shape(np.vstack([one.vertices, 2 * one.vertices + 50]), np.vstack([one.faces, one.faces + n]))
    found = remoteness(both, GivenDistance(along_edges(both)))
    alone = remoteness(one, GivenDistance(along_edges(one)))
    assert found == pytest.approx(np.concatenate([alone, 2 * alone]))


def test_edges_of_a_small_triangle():
    shape = as_shape(np.eye(3), [[0, 1, 2]])
    assert (_edges(shape).toarray() > 0).tolist() == (~np.eye(3, dtype=bool)).tolist()


def meeting_levels(shape, field):
    """The highest level above which there is a way between two vertices: of its lowest place, at best."""
    levels = np.where(np.eye(len(field), dtype=bool), field, -np.inf)
    for face in shape.faces:
        for a, b in ((face[0], face[1]), (face[1], face[2]), (face[2], face[0])):
            levels[a, b] = levels[b, a] = min(field[a], field[b])
    for k in range(len(field)):
        levels = np.maximum(levels, np.minimum(levels[:, [k]], levels[[k]]))
    return levels


def test_limbs_of_a_small_cross():
    """Three arms, the longest first: each reaches down to the level at which it meets another one."""
    shape = cross((6, 5, 4))
    lengths = along_edges(shape)
    mirror = np.arange(len(shape.vertices))
    limbs = find_limbs(shape, GivenDistance(lengths), mirror)
    ends = shape.vertices[limbs.tips]
    assert len(limbs) == 3
    assert ends[0, 0] == 7
    assert ends[1, 1] == 6
    assert ends[2, 0] == -4
    assert (limbs.mirror == [0, 1, 2]).all()
    assert find_limbs(shape, GivenDistance(lengths)).mirror is None
    field = limbs.remoteness
    assert (field == remoteness(shape, GivenDistance(lengths))).all()
    lowest = meeting_levels(shape, field)
    for limb, tip in enumerate(limbs.tips):
        foot = max(lowest[tip, other] for other in limbs.tips if other != tip)
        assert ((limbs.of_vertex == limb) == (lowest[tip] > foot)).all()
    assert (limbs.of_vertex == -1).sum() > 1


def test_small_points_are_on_the_limb_of_their_nearest_corner():
    shape = cross((3, 2, 1))
    v = len(shape.vertices)
    limbs = Limbs(np.array([3]), np.arange(v) % 4 - 1, np.random.default_rng(0).uniform(size=v))
    points = SurfacePoints(*random_points(shape, 50))
    for k, (face, weights) in enumerate(zip(points.face_ids, points.barycentrics, strict=True)):
        corner = shape.faces[face][list(weights).index(max(weights))]
        assert limbs.of_points(shape, points)[k] == limbs.of_vertex[corner]
        mean = sum(w * limbs.remoteness[c] for w, c in zip(weights, shape.faces[face], strict=True))
        assert limbs.remoteness_of(shape, points)[k] == pytest.approx(mean)


@pytest.mark.parametrize("seed", range(8))
def test_small_shares_by_loops(seed):
    """Limbs with ten points or more that the target shows: more than half on the right one, or its image."""
    rng = np.random.default_rng(seed)
    here = np.repeat([0, 1, 2, 3, 4, -1], [10, 9, 14, 12, 11, 20])
    there = np.where(rng.uniform(size=len(here)) < 0.5, here, rng.choice([-1, 0, 1, 2, 3, 4], len(here)))
    swapped = np.isin(here, rng.choice(5, 2))
    image = np.array([3, 2, 1, 0, 4, -1])
    there = np.where(swapped, image[here], there)
    shown, mirror = rng.choice([-1, 0, 1, 2, 3, 4], 6), image[:5].copy()
    mirror[1] = -1
    right, mirrored = [], []
    for limb in range(5):
        own = there[here == limb].tolist()
        if len(own) < 10 or limb not in shown.tolist():
            continue
        right.append(own.count(limb) > len(own) / 2)
        other = mirror[limb]
        if other not in (-1, limb) and other in shown.tolist():
            mirrored.append(own.count(other) > len(own) / 2)
    expected = tuple(sum(each) / len(each) if each else None for each in (right, mirrored))
    assert limb_shares(here, there, shown, mirror) == expected
    assert limb_shares(here, there, shown, None) == (expected[0], None)
