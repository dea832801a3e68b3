"""The text of a scene, read back by hand as a browser does."""

import base64
import json
import struct
import zlib

import numpy as np
import pytest

from reports.viewer.packing import octahedral, packed
from reports.viewer.scene import Scene, ViewCloud, ViewField, ViewMap
from reports.viewer.view_page import view_page

RNG = np.random.default_rng(0)


def unpacked(text):
    """Head of a packed scene, and a function that gives the array of an entry."""
    data = zlib.decompress(base64.b64decode(text))
    size = struct.unpack_from("<I", data)[0]
    head = json.loads(data[4 : 4 + size])
    return head, lambda entry: np.frombuffer(data, f"<{entry['kind']}", entry["count"], entry["start"])


def cloud(n, scale=1.0, **more):
    points = RNG.normal(size=(n, 3)) * [1, 3, 0.5] * scale
    normals = RNG.normal(size=(n, 3))
    return ViewCloud("a", points, normals / np.linalg.norm(normals, axis=1, keepdims=True), **more)


def placed(entry, array):
    return np.array(entry["low"]) + entry["step"] * array(entry["points"]).reshape(-1, 3)


def test_positions_keep_their_shape_to_a_ten_thousandth():
    given = cloud(500, scale=1700)
    head, array = unpacked(packed(Scene("a", (given,))))
    found = placed(head["clouds"][0], array)
    middle = (given.points.max(axis=0) + given.points.min(axis=0)) / 2
    ratio = np.linalg.norm(found, axis=1).max() / np.linalg.norm(given.points - middle, axis=1).max()
    assert np.allclose(found, (given.points - middle) * ratio, atol=1e-4)
    assert np.linalg.norm(found, axis=1).max() == pytest.approx(0.97, abs=1e-3)


def test_bodies_have_one_size_whatever_their_units():
    one = cloud(800)
    other = ViewCloud("b", one.points * 1000 + 5e4, one.normals)
    head, array = unpacked(packed(Scene("a", (one, other))))
    here, there = (placed(each, array) for each in head["clouds"])
    assert np.allclose(here, there, atol=2e-4)


def test_octahedral_normals_are_within_a_degree():
    given = RNG.normal(size=(2000, 3))
    given /= np.linalg.norm(given, axis=1, keepdims=True)
    x, y = (octahedral(given) / 127).T
    z = 1 - np.abs(x) - np.abs(y)
    folded = z < 0
    x[folded], y[folded] = (
        (1 - np.abs(y[folded])) * np.where(x[folded] >= 0, 1, -1),
        (1 - np.abs(x[folded])) * np.where(y[folded] >= 0, 1, -1),
    )
    found = np.stack([x, y, z], axis=1)
    found /= np.linalg.norm(found, axis=1, keepdims=True)
    assert np.degrees(np.arccos(np.clip((found * given).sum(axis=1), -1, 1))).max() < 1


def test_maps_and_fields_are_what_was_given():
    source, target = cloud(300, fields=(ViewField("h", "height", np.linspace(2, 4, 300), 2, 4),)), cloud(200)
    image = RNG.integers(-1, 200, size=300)
    errors = np.where(image < 0, np.nan, RNG.random(300) * 20)
    given = ViewMap(
        "m", image, confidence=np.linspace(0, 1, 300), errors=errors, landmarks=np.array([[1, 2]])
    )
    head, array = unpacked(packed(Scene("a", (source, target), (given,), truth=image)))
    found = head["maps"][0]
    assert array(found["image"]).tolist() == image.tolist()
    assert np.allclose(array(found["errors"]), errors, atol=1e-3, equal_nan=True)
    assert np.abs(array(found["confidence"]) / 255 - np.linspace(0, 1, 300)).max() <= 0.5 / 255 + 1e-12
    assert array(found["landmarks"]).tolist() == [1, 2]
    assert array(head["truth"]).tolist() == image.tolist()
    field = head["clouds"][0]["fields"][0]
    assert np.allclose(2 + 2 * (array(field["values"]) / 255), np.linspace(2, 4, 300), atol=0.005)


def test_twenty_thousand_points_a_side_take_less_than_a_megabyte():
    source, target = cloud(20000), cloud(20000)
    image = RNG.integers(0, 20000, size=20000)
    text = packed(Scene("a", (source, target), (ViewMap("m", image, confidence=RNG.random(20000)),)))
    assert len(text) < 1_000_000


def half(axis, sign):
    """The side of a ball that faces along an axis."""
    normals = RNG.normal(size=(600, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    normals = normals[sign * normals[:, axis] > 0]
    return ViewCloud("a", normals, normals)


@pytest.mark.parametrize(("up", "axis", "front"), [(0, 2, 1), (1, 2, 1), (2, 1, -1)])
def test_clouds_that_are_seen_from_inside_are_turned(up, axis, front):
    image = np.zeros(0, dtype=int)

    def sides(*signs):
        clouds = tuple(half(axis, front * sign) for sign in signs)
        head, _ = unpacked(packed(Scene("a", clouds, (ViewMap("m", image),) if len(signs) > 1 else (), up)))
        return head["start"], [each["behind"] for each in head["clouds"]]

    assert sides(1, 1) == ("front", [False, False])
    assert sides(1, -1) == ("front", [False, True])
    assert sides(-1, 1) == ("back", [False, True])
    assert sides(-1) == ("back", [False])


@pytest.mark.parametrize(
    "points", [np.zeros((0, 3)), np.zeros((1, 3)), np.zeros((5, 3))], ids=["no", "one", "equal"]
)
def test_degenerate_clouds_can_be_packed(points):
    head, array = unpacked(packed(Scene("a", (ViewCloud("a", points),))))
    assert np.isfinite(placed(head["clouds"][0], array)).all()


def test_a_name_cannot_become_part_of_the_page():
    page = view_page(Scene("</script><script>alert(1)</script>", (ViewCloud("<b>&", np.zeros((5, 3))),)))
    assert "<script>alert" not in page
    assert "&lt;/script&gt;" in page
