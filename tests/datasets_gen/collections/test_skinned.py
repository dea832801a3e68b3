import numpy as np
import pytest
from scipy.sparse import csr_array
from scipy.spatial.transform import Rotation

from datasets_gen import InputError
from datasets_gen.collections.skinned import collected, linear_blend_skinning, standing
from tests.datasets_gen.sample_meshes import sphere


def test_one_bone_moves_its_vertices_rigidly():
    points = np.random.default_rng(0).normal(size=(20, 3))
    turn = Rotation.from_euler("xyz", [20, 40, 60], degrees=True)
    weights = csr_array(np.tile([0.0, 1.0], (20, 1)))
    turns = np.stack([np.eye(3), turn.as_matrix()])
    moved = linear_blend_skinning(points, weights, turns, np.array([[9.0, 9, 9], [1, 2, 3]]))
    np.testing.assert_allclose(moved, turn.apply(points) + np.array([1, 2, 3]), atol=1e-12)


def test_half_weights_give_the_middle():
    turns = np.stack([np.eye(3), Rotation.from_euler("z", 90, degrees=True).as_matrix()])
    moved = linear_blend_skinning(
        np.array([[1.0, 0, 0]]), csr_array([[0.5, 0.5]]), turns, np.array([[0, 0, 0], [0, 0, 2.0]])
    )
    np.testing.assert_allclose(moved, [[0.5, 0.5, 1.0]], atol=1e-15)


def test_poses_stand_over_the_origin():
    low, high = np.percentile(standing(sphere(1).vertices + np.array([5, 6, 7])), [0, 100], axis=0)
    assert low[1] == 0
    np.testing.assert_allclose((low + high)[[0, 2]], 0, atol=1e-12)


def test_a_collection_shares_its_faces():
    mesh = sphere(2)
    body = collected("ball", mesh.faces[:, ::-1], {"rest": mesh.vertices, "long": mesh.vertices * [1, 2, 1]})
    assert body.reference is body.shapes[0]
    assert body.reference.units == "m"
    assert body["long"].faces is body.reference.faces
    np.testing.assert_array_equal(body.reference.faces, mesh.faces)  # wound outward


def test_a_pose_without_area_is_named():
    mesh = sphere(1)
    flat = mesh.vertices.copy()
    flat[mesh.faces[3]] = flat[mesh.faces[3, 0]]
    with pytest.raises(InputError, match="'ball/bad' has faces without area"):
        collected("ball", mesh.faces, {"rest": mesh.vertices, "bad": flat})
