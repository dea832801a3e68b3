"""The compiled kernels against slow references, and the graph of nodes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial.transform import Rotation

from medial.matching.registration.closest_points import meeting
from medial.matching.registration.deformation_graph import (
    BEND,
    SHARED,
    Attachment,
    NodeGraph,
    Pose,
    attach,
    moved,
    shares,
)
from medial.matching.registration.energy_terms import add_points, add_pulls
from medial.matching.registration.envelope import Envelope
from medial.matching.registration.normal_equations import NormalEquations
from medial.matching.registration.rigid_motions import LARGEST_TURN, local_motions, turned
from medial.matching.registration.strongest_paths import strongest_paths
from tests.medial.clouds import rotation
from tests.medial.posed import bent, figure, rest_pose, rigid_pose, turns

STEP = 1e-5


def blob(n=60, nodes=9, seed=0):
    """Points of a small random cloud that are their own coordinates, with a graph over them."""
    points = np.random.default_rng(seed).standard_normal((n, 3)) * [0.5, 0.2, 0.2]
    graph, attachment = NodeGraph.over(points.astype(np.float32), points, np.arange(n), nodes)
    return points, graph, attachment


def graph_over_a_rod(nodes):
    points = np.random.default_rng(0).standard_normal((800, 3)) * [8, 0.1, 0.1]
    return NodeGraph.over(points.astype(np.float32), points, np.arange(800), nodes)


def disturbed(graph, size, seed=0):
    """The pose of a rigid motion, with every node turned and shifted a little more."""
    random = np.random.default_rng(seed)
    turn = Rotation.from_rotvec(size * random.standard_normal((len(graph), 3))).as_matrix()
    place = size * random.standard_normal((len(graph), 3))
    rigid = rigid_pose(graph, rotation(3), [0.2, -0.1, 0.3])
    return Pose(turn @ rigid.rotations, rigid.positions + place)


def stepped(pose, change):
    """The pose after an infinitesimal motion, turns by scipy."""
    change = change.reshape(-1, 6)
    turn = Rotation.from_rotvec(change[:, :3]).as_matrix()
    return Pose(turn @ pose.rotations, pose.positions + change[:, 3:])


def derivative(function, size):
    """Central differences of a function of a motion, one column per unknown."""
    columns = [(function(STEP * e) - function(-STEP * e)) / (2 * STEP) for e in np.eye(size)]
    return np.stack(columns, axis=-1)


def slow_moved(points, attachment, graph, pose):
    out = np.zeros_like(points)
    for i, x in enumerate(points):
        for j, w in zip(attachment.nodes[i], attachment.weights[i], strict=True):
            out[i] += w * (pose.rotations[j] @ (x - graph.rest[j]) + pose.positions[j])
    return out


def full(lower):
    return np.tril(lower) + np.tril(lower, -1).T


def slow_gaps(graph, pose):
    """Disagreements of the neighbours, (E, 9): about either node's place, and about their turns."""
    out = []
    for i, j in graph.edges:
        ends = [
            (pose.rotations[i] @ (x - graph.rest[i]) + pose.positions[i])
            - (pose.rotations[j] @ (x - graph.rest[j]) + pose.positions[j])
            for x in (graph.rest[i], graph.rest[j])
        ]
        turn = Rotation.from_matrix(pose.rotations[i] @ pose.rotations[j].T).as_rotvec()
        out.append(np.concatenate([*ends, graph.reach * turn]))
    return np.array(out)


def slow_strain(graph, pose):
    square = (slow_gaps(graph, pose) ** 2).sum(axis=1)
    return (graph.hold * 2 * BEND**2 * (np.sqrt(1 + square / BEND**2) - 1)).sum()


@pytest.mark.uncompiled
def test_points_and_directions_are_blended():
    points, graph, attachment = blob()
    directions = points / np.linalg.norm(points, axis=1, keepdims=True)
    pose = disturbed(graph, 0.3)
    here, there = moved(points, directions, attachment, graph, pose)
    assert np.allclose(here, slow_moved(points, attachment, graph, pose))
    blended = np.einsum("nk,nkij,nj->ni", attachment.weights, pose.rotations[attachment.nodes], directions)
    assert np.allclose(there, blended / np.linalg.norm(blended, axis=1, keepdims=True))


@pytest.mark.uncompiled
def test_a_rigid_pose_moves_everything_rigidly():
    points, graph, attachment = blob()
    turn, shift = rotation(5), np.array([1.0, -2.0, 0.5])
    here, there = moved(points, points, attachment, graph, rigid_pose(graph, turn, shift))
    assert np.allclose(here, points @ turn.T + shift)
    assert np.allclose(there, points @ turn.T / np.linalg.norm(points, axis=1, keepdims=True))


def pulled(seed=1):
    points, graph, attachment = blob()
    pose = disturbed(graph, 0.3)
    random = np.random.default_rng(seed)
    goal = random.standard_normal((len(points), 3))
    normals = random.standard_normal((len(points), 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    even, along = random.uniform(0.1, 1, (2, len(points)))
    even[:20] = along[10:30] = 0  # ten points have no weight at all
    return points, graph, attachment, pose, goal, normals, even, along


def normal_equations(points, graph, attachment, pose, offset, normals, even, along):
    metric, force = np.zeros((len(points), 3, 3)), np.zeros((len(points), 3))
    add_pulls(metric, force, np.arange(len(points)), offset, normals, even, along)
    values, right = graph.envelope.zeros(), np.zeros(6 * len(graph))
    nodes, weights, turn = attachment.nodes, attachment.weights, pose.rotations
    origin = graph.envelope.origin
    add_points(values, origin, right, points, nodes, weights, graph.rest, turn, metric, force)
    return graph.envelope.dense(values), right


@pytest.mark.uncompiled
def test_pulls_on_one_point_add_up():
    random = np.random.default_rng(0)
    rows = np.array([2, 0, 2, 2])
    offset, normals = random.standard_normal((2, 4, 3))
    even, along = random.uniform(0, 1, (2, 4))
    metric, force = np.zeros((3, 3, 3)), np.zeros((3, 3))
    add_pulls(metric, force, rows, offset, normals, even, along)
    for j in range(3):
        terms = [e * np.eye(3) + a * np.outer(n, n) for e, a, n in zip(even, along, normals, strict=True)]
        mine = np.flatnonzero(rows == j)
        assert np.allclose(metric[j], sum((terms[i] for i in mine), np.zeros((3, 3))))
        assert np.allclose(force[j], sum((terms[i] @ offset[i] for i in mine), np.zeros(3)))


@pytest.mark.uncompiled
def test_meeting():
    random = np.random.default_rng(0)
    points, goals, normals, goal_normals = random.standard_normal((4, 50, 3))
    goal_normals[0] = 3 * normals[0]
    square, cosine = meeting(points, normals, goals, goal_normals)
    assert np.allclose(square, np.linalg.norm(points - goals, axis=1) ** 2)
    expected = np.clip((normals * goal_normals).sum(axis=1), 0, 1)
    assert (expected == 0).any()
    assert (expected == 1).any()
    assert np.allclose(cosine, expected)


def test_normal_equations_of_the_pull():
    """With residuals r, J = dr / d(motion) and weights W: the system is J'WJ, the right-hand side J'Wr."""
    points, graph, attachment, pose, goal, normals, even, along = pulled()
    size = 6 * len(graph)
    offset = slow_moved(points, attachment, graph, pose) - goal
    system, right = normal_equations(points, graph, attachment, pose, offset, normals, even, along)
    place = derivative(lambda c: slow_moved(points, attachment, graph, stepped(pose, c)), size)
    metric = even[:, None, None] * np.eye(3) + along[:, None, None] * normals[:, :, None] * normals[:, None]
    assert np.allclose(full(system), np.einsum("nap,nab,nbq->pq", place, metric, place), atol=1e-7)
    assert np.allclose(right, np.einsum("nap,nab,nb->p", place, metric, offset), atol=1e-7)


@pytest.mark.uncompiled
def test_right_hand_side_is_half_the_gradient_of_the_pull():
    points, graph, attachment, pose, goal, normals, even, along = pulled()

    def energy(change):
        gap = slow_moved(points, attachment, graph, stepped(pose, change)) - goal
        return (even * (gap**2).sum(axis=1) + along * (normals * gap).sum(axis=1) ** 2).sum()

    size = 6 * len(graph)
    offset = slow_moved(points, attachment, graph, pose) - goal
    right = normal_equations(points, graph, attachment, pose, offset, normals, even, along)[1]
    assert np.abs(right).max() > 1
    assert np.allclose(2 * right, derivative(energy, size), atol=1e-6)


@pytest.mark.uncompiled
@pytest.mark.parametrize("size", [0.005, 0.3])  # well below and well above BEND
def test_strain_and_its_gradient(size):
    _, graph, _ = blob()
    pose, unknowns = disturbed(graph, size), 6 * len(graph)
    right = np.zeros(unknowns)
    graph.add_edges(graph.envelope.zeros(), right, pose, 3.0)
    assert graph.strain(pose) == pytest.approx(slow_strain(graph, pose), rel=1e-9)
    slope = derivative(lambda c: slow_strain(graph, stepped(pose, c)), unknowns)
    assert np.abs(slope).max() > 1e-4
    assert np.allclose(right, 3.0 / 2 * slope, rtol=1e-5, atol=1e-8)


def test_system_of_the_edges_is_that_of_gauss_and_newton():
    """Where neighbours turn alike; elsewhere the derivative of a turn by a turn is left out."""
    _, graph, _ = blob()
    pose = disturbed(graph, 0.02)
    pose = Pose(np.tile(rotation(1), (len(graph), 1, 1)), pose.positions)
    size = 6 * len(graph)
    values = graph.envelope.zeros()
    graph.add_edges(values, np.zeros(size), pose, 2.0)
    root = np.sqrt(1 + (slow_gaps(graph, pose) ** 2).sum(axis=1) / BEND**2)
    gaps = derivative(lambda c: slow_gaps(graph, stepped(pose, c)), size)
    expected = np.einsum("e,eap,eaq->pq", 2 * graph.hold / root, gaps, gaps)
    assert np.allclose(full(graph.envelope.dense(values)), expected, atol=1e-8)


def test_values_spread_over_the_nodes():
    points, _, attachment = blob(200, 12)
    rows = np.arange(0, 200, 3)
    assert np.allclose(attachment.smoothed(rows, np.full(len(rows), 0.7)), 0.7)
    along = attachment.smoothed(rows, points[rows, 0])
    assert np.corrcoef(along, points[:, 0])[0, 1] > 0.9
    assert along.min() >= points[rows, 0].min()
    assert along.max() <= points[rows, 0].max()


def test_nodes_are_numbered_along_the_body():
    graph, attachment = graph_over_a_rod(60)
    assert len(graph.envelope.zeros()) < 360**2 / 4
    spread = np.ptp(attachment.nodes, axis=1)
    assert spread.max() < 12  # a point hangs on nodes beside each other, so that rows of the system are short


def test_numbering_keeps_nodes_and_their_points_together():
    points, graph, attachment = blob(200, 12)
    share = shares(attachment, len(graph)).toarray()
    assert np.allclose(share.sum(axis=1), 1)
    assert np.allclose(share.T @ points / share.sum(axis=0)[:, None], graph.rest)
    gap = np.linalg.norm(points[:, None] - graph.coordinates, axis=2)
    assert np.array_equal(attachment.nodes[:, 0], gap.argmin(axis=1))
    held = {tuple(edge) for edge in graph.edges}
    most = share.T @ share / share.sum(axis=0).mean()
    assert all((i, j) in held for i, j in np.argwhere(np.triu(most, 1) > SHARED))


@pytest.mark.uncompiled
def test_steps_bring_points_to_their_goals():
    points, graph, attachment = blob()
    pose = disturbed(graph, 0.2)
    goal = slow_moved(points, attachment, graph, disturbed(graph, 0.1, seed=4))
    none = np.zeros(len(points))
    gaps = []
    for _ in range(8):
        offset = moved(points, points, attachment, graph, pose)[0] - goal
        gaps.append(np.linalg.norm(offset, axis=1).mean())
        equations = NormalEquations(graph, pose, points, attachment)
        equations.pull(np.arange(len(points)), offset, points, none + 1, none)
        pose = equations.step(1e-3)
    assert gaps[-1] < 0.02 * gaps[0]


@pytest.mark.uncompiled
def test_turns_are_those_of_scipy_up_to_the_largest():
    random = np.random.default_rng(2)
    before = Rotation.random(50, random_state=3).as_matrix()
    vectors = random.standard_normal((50, 3)) * 0.5
    vectors[0] = 0
    length = np.linalg.norm(vectors, axis=1)
    assert (length > LARGEST_TURN).any()
    capped = vectors * np.minimum(1, LARGEST_TURN / np.maximum(length, 1e-9))[:, None]
    expected = Rotation.from_rotvec(capped).as_matrix() @ before
    assert np.allclose(turned(before, vectors), expected)


def wide(attachment, points, graph):
    """All points for every node, as `local_motions` takes them."""
    count, n = len(graph), len(points)
    share = np.zeros((n, count))
    np.put_along_axis(share, attachment.nodes, attachment.weights, axis=1)
    return np.arange(count + 1) * n, np.tile(np.arange(n), count), (share.T + 0.05).ravel()


@pytest.mark.uncompiled
@pytest.mark.parametrize("outliers", [0.0, 0.2])
def test_local_motions_find_a_rigid_motion(outliers):
    points, graph, attachment = blob(n=200)
    random = np.random.default_rng(6)
    normals = random.standard_normal(points.shape)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    turn, shift = rotation(8), np.array([0.3, 0.1, -0.2])
    goal = points @ turn.T + shift
    wrong = random.uniform(size=len(points)) < outliers
    goal[wrong] += random.uniform(-2, 2, (wrong.sum(), 3))
    rotations, placed = local_motions(
        points, normals, goal, normals @ turn.T, *wide(attachment, points, graph), graph.rest, 0.1, 0.01
    )
    tolerance = 1e-9 if outliers == 0 else 0.02
    assert np.abs(rotations - turn).max() < tolerance
    assert np.abs(placed - (graph.rest @ turn.T + shift)).max() < tolerance
    assert np.allclose(np.linalg.det(rotations), 1)


def test_weights_are_shares():
    coordinates = np.random.default_rng(0).standard_normal((300, 4)).astype(np.float32)
    hang = attach(coordinates, coordinates[:20])
    assert (hang.weights >= 0).all()
    assert np.allclose(hang.weights.sum(axis=1), 1)
    assert (np.diff(np.sort(hang.nodes, axis=1), axis=1) > 0).all()  # six different nodes
    gap = np.linalg.norm(coordinates[:, None] - coordinates[:20], axis=2)
    assert np.array_equal(hang.nodes[:, 0], gap.argmin(axis=1))
    assert np.array_equal(hang.weights.argmax(axis=1), np.zeros(300))
    part = hang.rows(np.array([7, 3]))
    assert np.array_equal(part.nodes, hang.nodes[[7, 3]])
    assert np.array_equal(part.weights, hang.weights[[7, 3]])


def test_the_graph_of_two_components_is_connected():
    random = np.random.default_rng(0)
    points = random.standard_normal((400, 3))
    points[200:] += [100, 0, 0]
    coordinates = points.astype(np.float32)
    graph, _ = NodeGraph.over(coordinates, points, np.arange(400), 30)
    far = np.abs(graph.rest[graph.edges[:, 0], 0] - graph.rest[graph.edges[:, 1], 0]) > 50
    joined = coo_array((np.ones(len(graph.edges)), tuple(graph.edges.T)), shape=(30, 30))
    assert connected_components(joined, directed=False)[0] == 1
    assert far.sum() == 1  # nothing else than the bridge
    assert graph.hold.sum() == pytest.approx(1)
    assert (graph.edges[:, 0] < graph.edges[:, 1]).all()


def chain(count=6):
    edges = np.column_stack([np.arange(count - 1), np.arange(1, count)])
    rest = np.column_stack([0.2 * np.arange(count), np.zeros((count, 2))])
    hold, envelope = np.full(count - 1, 1 / (count - 1)), Envelope(np.maximum(np.arange(count) - 1, 0))
    return NodeGraph(rest.astype(np.float32), rest, edges, hold, 0.1, envelope)


def test_parts_of_a_chain():
    parts = chain().parts(np.array([True, True, False, True, False, True]))
    assert [part.tolist() for part in parts] == [[0, 1], [3], [5]]
    assert chain().parts(np.zeros(6, dtype=bool)) == []


@pytest.mark.uncompiled
def test_strain_of_a_chain():
    graph = chain()
    assert graph.strain(rigid_pose(graph, rotation(2), [5.0, 1.0, -3.0])) < 1e-20
    turn = Rotation.from_rotvec(np.outer(np.arange(6), [0, 0, 0.2])).as_matrix()
    bend = Pose(turn, rest_pose(graph).positions)
    sharper = Pose(turn @ turn, bend.positions)
    assert 1e-5 < graph.strain(bend) < graph.strain(sharper)


@pytest.mark.uncompiled
def test_a_node_turned_by_half_a_turn_strains_the_graph():
    graph = chain()
    pose = rest_pose(graph)
    pose.rotations[3:] = np.diag([1.0, -1, -1])  # about the chain itself: only the turns disagree
    nearly = rest_pose(graph)
    nearly.rotations[3:] = Rotation.from_rotvec([np.pi - 1e-3, 0, 0]).as_matrix()
    assert graph.strain(pose) == pytest.approx(graph.strain(nearly), rel=0.01)


def test_mixed_poses_take_the_given_nodes():
    graph = chain()
    here, there = disturbed(graph, 0.1, seed=1), disturbed(graph, 0.1, seed=2)
    mixed = here.mixed(there, np.array([1, 4]))
    for k in range(6):
        origin = there if k in (1, 4) else here
        assert np.array_equal(mixed.rotations[k], origin.rotations[k])
        assert np.array_equal(mixed.positions[k], origin.positions[k])
    assert not np.array_equal(here.positions[1], there.positions[1])


@pytest.fixture(scope="module")
def graph():
    """Nodes over the figure, whose area is 1."""
    diffusion = figure()
    points = diffusion.points / np.sqrt(diffusion.areas.sum())
    coordinates = (diffusion.eigenfunctions * np.exp(-0.03 * diffusion.eigenvalues)).astype(np.float32)
    return NodeGraph.over(coordinates, points, np.arange(len(points)), 60)[0]


def elbow(graph, angle):
    """The pose of the graph with one elbow bent."""
    unit = np.sqrt(figure().areas.sum())
    turn, _ = turns(graph.rest * unit, angle)
    return Pose(turn, bent(graph.rest * unit, graph.rest, angle)[0] / unit)


def test_nothing_tears_in_a_rigid_motion(graph):
    assert np.allclose(graph.held(rigid_pose(graph, rotation(4), [1.0, 0.0, 2.0])), 1)


def test_a_bent_elbow_holds(graph):
    pose = elbow(graph, 1.0)
    assert 1e-6 < graph.strain(pose) < 0.01
    assert graph.held(pose).min() > 0.9


def test_a_torn_arm_does_not_hold(graph):
    unit = np.sqrt(figure().areas.sum())
    arm = graph.rest[:, 0] * unit > 0.4
    assert 3 <= arm.sum() <= 20
    pose = rest_pose(graph)
    pose.positions[arm] += [0.5, 0, 0.5]
    held = graph.held(pose)
    assert held[arm].max() < 0.5
    assert held[~arm].min() > 0.9


def test_attachments_to_fewer_nodes_than_influences():
    points = np.random.default_rng(0).standard_normal((30, 3))
    graph, hang = NodeGraph.over(points.astype(np.float32), points, np.arange(30), 3)
    assert isinstance(hang, Attachment)
    assert hang.nodes.shape == (30, 2)
    assert np.allclose(hang.weights.sum(axis=1), 1)
    assert np.allclose(moved(points, points, hang, graph, rest_pose(graph))[0], points)


@pytest.mark.uncompiled
@settings(max_examples=30, deadline=None, derandomize=True, database=None)
@given(st.integers(2, 12), st.integers(0, 40), st.integers(0, 10**6))
def test_the_strongest_path_is_as_strong_as_its_weakest_edge(count, size, seed):
    random = np.random.default_rng(seed)
    edges = random.integers(0, count, (size, 2))
    strength = random.random(size).round(1)  # with ties
    best = np.eye(count)
    for (i, j), value in zip(edges, strength, strict=True):
        best[i, j] = best[j, i] = max(best[i, j], value)
    for k in range(count):
        best = np.maximum(best, np.minimum(best[:, k : k + 1], best[k]))
    assert np.array_equal(strongest_paths(count, edges, strength), best)
