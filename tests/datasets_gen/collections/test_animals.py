"""Dog and rodent; what needs MuJoCo or the files of dm-control is skipped where they are not installed."""

import struct

import numpy as np
import pytest
from scipy.spatial import cKDTree

from datasets_gen import InputError, check_mesh, load
from datasets_gen.collections import animals
from datasets_gen.collections.animal_poses import POSES
from datasets_gen.collections.animals import MODELS, WHEEL, bind_bodies, bone_motions, load_animal
from datasets_gen.registry import SOURCES, outline
from tests.datasets_gen.collections.wheels import install
from tests.datasets_gen.sample_meshes import sphere

real = pytest.mark.skipif(WHEEL.missing() is not None, reason=str(WHEEL.missing()))

MODEL = """<mujoco>
  <asset><skin name="skin" file="worm.skn"/></asset>
  <worldbody>
    <body name="tail"><geom size=".1"/>
      <body name="head" pos="1 0 0"><geom size=".1"/>
        <joint name="nod" axis="0 -1 0" limited="true" range="-20 90"/>
      </body>
    </body>
  </worldbody>
</mujoco>
"""


def skin_bytes(vertices, faces, bones):
    """A MuJoCo skin: four counts, then vertices, faces and bones, each bone with its name in 40 bytes."""
    content = struct.pack("<4i", len(vertices), 0, len(faces), len(bones))
    content += np.asarray(vertices, dtype="<f4").tobytes() + np.asarray(faces, dtype="<i4").tobytes()
    for name, place, weights in bones:
        ids = np.flatnonzero(weights)
        content += name.encode().ljust(40, b"\0") + struct.pack("<7f", *place, 1, 0, 0, 0)
        content += struct.pack("<i", len(ids)) + ids.astype("<i4").tobytes()
        content += np.asarray(weights)[ids].astype("<f4").tobytes()
    return content


@pytest.fixture
def worm(tmp_path, monkeypatch):
    """A worm along x, cut into triangles, whose fore half is bound to its head; 1.5 times its model."""
    pytest.importorskip("mujoco")
    package = install(monkeypatch, tmp_path, WHEEL)
    mesh = sphere(3)
    along = mesh.vertices * [1.5, 0.4, 0.4] + [1.5, 0, 1]
    soup = along[mesh.faces].reshape(-1, 3)
    fore = (soup[:, 0] > 1.5).astype(float)
    bones = [("tail", (0, 0, 1), 1 - fore), ("head", (1.5, 0, 1), fore)]
    (package / "worm.xml").write_text(MODEL, encoding="utf-8")
    (package / "worm.skn").write_bytes(skin_bytes(soup, np.arange(len(soup)).reshape(-1, 3), bones))
    monkeypatch.setitem(MODELS, "worm", "worm.xml")
    monkeypatch.setitem(POSES, "worm", {"rest": {}, "nod": {"nod": 90.0}})
    monkeypatch.setitem(animals.PITCH, "worm", {"nod": 90.0})
    return package


def test_the_skin_is_welded_and_keeps_its_own_size(worm):
    body = load_animal("worm")
    assert body.poses == ("rest", "nod")
    assert body.reference.pose == "rest"
    assert len(body.reference.vertices) == len(sphere(3).vertices)
    assert check_mesh(body.reference) == ()
    np.testing.assert_allclose(np.ptp(body.reference.vertices, axis=0), [0.8, 0.8, 3], atol=1e-6)  # z forward


def test_the_bound_half_turns_about_its_joint(worm):
    """The head goes up by 90 degrees, then all does: the tail points down, and the head backward."""
    body = load_animal("worm")
    nod, tip = body["nod"].vertices, body.reference.vertices[:, 2].argmax()
    np.testing.assert_allclose(np.ptp(nod, axis=0), [0.8, 1.5 + 0.4, 1.5 + 0.4], atol=0.01)
    assert nod[tip, 2] == pytest.approx(nod[:, 2].min())
    assert nod[:, 1].min() == 0


def test_a_model_is_moved_to_where_its_skin_is_bound(worm):
    import mujoco

    model = mujoco.MjModel.from_xml_path(str(worm / "worm.xml"))
    np.testing.assert_allclose(bone_motions(model, {})[1][1], [-0.5, 0, -1])
    bind_bodies(model)
    turns, shifts = bone_motions(model, {})
    np.testing.assert_allclose(turns, np.tile(np.eye(3), (2, 1, 1)))
    np.testing.assert_allclose(shifts, np.tile([0, 0, -1.0], (2, 1)))  # as one piece


@pytest.mark.parametrize(
    ("pose", "reason"),
    [
        ({"nod": -21.0}, "joint 'nod' turns from -20 to 90 degrees, not by -21"),
        ({"wag": 1.0}, "no joint 'wag'"),
    ],
)
def test_poses_beyond_the_joints_are_refused(pose, reason, worm, monkeypatch):
    monkeypatch.setitem(POSES, "worm", {"rest": {}, "bad": pose})
    with pytest.raises(InputError, match=reason):
        load_animal("worm")


def test_a_broken_skin_is_told(worm):
    (worm / "worm.skn").write_bytes(b"\1\0\0\0")
    with pytest.raises(InputError, match=r"worm\.xml' cannot be used"):
        load_animal("worm")


def test_missing_packages_are_told(monkeypatch):
    monkeypatch.setattr("datasets_gen.collections.wheel_files.find_spec", lambda name: None)
    with pytest.raises(
        InputError, match=r"dm_control and mujoco are missing: pip install 'medialbench\[animals\]'"
    ):
        load("dog")
    assert "medialbench[animals]" in SOURCES["rodent"].missing


@pytest.mark.parametrize("name", ["dog", "rodent"])
def test_the_outline_needs_no_files(name, tmp_path, monkeypatch):
    pytest.importorskip("mujoco")
    install(monkeypatch, tmp_path, WHEEL)
    told = outline(name)
    assert told["reference"] == "stand"
    assert len(told["poses"]) >= 8
    with pytest.raises(InputError, match="no pose 'fly'"):
        outline(name, poses=["fly"])


@real
@pytest.mark.parametrize(("name", "vertices"), [("dog", 16_952), ("rodent", 5_371)])
def test_the_animals_are_closed_in_all_poses(name, vertices, tmp_path, monkeypatch):
    monkeypatch.setenv("MEDIALBENCH_CACHE", str(tmp_path))
    body = load(name)
    assert len(body.reference.vertices) == vertices
    assert all(check_mesh(shape) == () for shape in body)
    assert body.mirror is not None
    mirrored = body.reference.vertices * [-1, 1, 1]
    assert cKDTree(body.reference.vertices).query(mirrored)[0].max() < 0.02 * body.reference.diagonal
    assert list(tmp_path.glob("dm-control-*.licence.txt"))
