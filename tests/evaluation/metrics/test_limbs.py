import numpy as np
import pytest

from datasets_gen import load
from evaluation.metrics.correspondence import SurfacePoints
from evaluation.metrics.geodesic import SurfaceDistance
from evaluation.metrics.limbs import LEAST, find_limbs, limb_shares
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
