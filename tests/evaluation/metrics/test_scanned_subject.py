"""A scan is told from the mesh of another subject by its neighbours."""

from dataclasses import replace

import numpy as np
import pytest
import trimesh

from datasets_gen import InputError, Shape, load
from evaluation.metrics.scanned_subject import check_subject, neighbours_kept
from scanner_sim import sample


@pytest.fixture(scope="module")
def ball():
    mesh = trimesh.creation.icosphere(subdivisions=3)
    return Shape(mesh.vertices * [1, 1.4, 2], np.array(mesh.faces, np.int32), "ball/rest", "ball", "rest")


@pytest.mark.parametrize("count", [60, 500])
def test_a_round_body_with_faces_in_another_order_is_noticed(ball, count):
    scan = sample(ball, count, seed=0)
    order = np.random.default_rng(0).permutation(len(ball.faces))
    assert neighbours_kept(scan, ball) == 1
    with pytest.raises(InputError, match="0% of its points keep their neighbours"):
        check_subject(scan, replace(ball, faces=ball.faces[order]))


@pytest.mark.parametrize("count", [60, 500])
def test_a_scan_of_one_pose_belongs_to_every_other(count):
    body = load("human")
    scan = sample(body["rest"], count, seed=1)
    for pose in body:
        check_subject(scan, replace(pose, vertices=1000 * pose.vertices))
