"""Colours as albedo: the sRGB standard, exact interpolation, and what the camera receives."""

from dataclasses import replace

import numpy as np
import pytest

from datasets_gen import InputError
from datasets_gen.meshes.colours import Texture
from scanner_sim import ScannerConfig, scan
from scanner_sim.scanner import Rig
from scanner_sim.tracing import albedo

SMALL = {"views": 2, "resolution": (60, 60)}


def radiance(shape, material, attributes=None, **settings):
    rig = Rig(shape, ScannerConfig(**SMALL, material=material, **settings), attributes)
    return rig.tracer.view(rig.poses[0])


def test_srgb_is_decoded_as_the_standard_says():
    """IEC 61966-2-1: the grey of 18 % reflectance is stored as 118; the curve is continuous at .04045."""
    assert albedo.linear(np.array(118 / 255)) == pytest.approx(0.18, abs=0.002)
    assert albedo.linear(np.array([0.0, 1.0])).tolist() == [0, 1]
    low, high = albedo.linear(np.array([0.04045, 0.0404501]))
    assert high == pytest.approx(low, rel=1e-4)


@pytest.mark.parametrize(
    ("wavelength", "weights"),
    [
        (405, (0, 0, 1)),
        (450, (0, 0, 1)),
        (491, (0, 0.5, 0.5)),
        (532, (0, 1, 0)),
        (586, (0.5, 0.5, 0)),
        (650, (1, 0, 0)),
        (850, (1, 0, 0)),
    ],
)
def test_lasers_see_the_channel_of_their_colour(wavelength, weights):
    assert albedo.channel_weights(wavelength) == pytest.approx(weights)


def test_a_red_laser_sees_no_blue(capsule):
    colours = np.zeros((len(capsule.faces), 3), np.uint8)
    colours[:, 2] = 255
    red = radiance(capsule, "colours", {"face_colour": colours}, wavelength=650.0)
    blue = radiance(capsule, "colours", {"face_colour": colours}, wavelength=450.0)
    assert (red.radiance < 1e-5).all()
    assert np.array_equal(blue.radiance, radiance(capsule, "white").radiance)


def test_vertex_colours_are_interpolated_in_linear_light(capsule, each_variant):
    colours = np.random.default_rng(0).integers(0, 256, (len(capsule.vertices), 4), np.uint8)
    seen, white = radiance(capsule, "colours", {"vertex_colour": colours}), radiance(capsule, "white")
    red = albedo.linear(colours[:, 0] / 255)
    expected = (red[capsule.faces[seen.face_ids]] * seen.barycentrics).sum(axis=1)
    assert np.allclose(seen.radiance, expected * white.radiance, atol=1e-12)


def checkered(plate):
    """The front of a plate under 4 x 4 squares of grey 235 and 118, texture coordinates from x and y."""
    squares = np.where(np.indices((4, 4)).sum(axis=0) % 2 == 0, 235, 118).astype(np.uint8)
    image = np.repeat(np.repeat(squares, 64, axis=0), 64, axis=1)[..., None].repeat(3, axis=2)
    uv = plate.vertices[:, :2] / 75 + 0.5
    return Texture.of_vertices(image, uv, plate.faces)


def test_a_checkerboard_returns_light_in_the_ratio_of_its_albedos(plate):
    """Peaks measured through stripes, sensor and fit: linear 235 over linear 118 is 4.57."""
    rig = {"views": ((0, 0, 1),), "resolution": (160, 160), "fit": "least_squares"}
    config = ScannerConfig(**rig, bits=0, material="colours", peak_threshold=0.05)
    found = scan(plate, config, attributes={"texture": checkered(plate)})
    white = scan(plate, replace(config, material="white"))
    assert np.array_equal(found.pixels, white.pixels)
    place = (found.true_points[:, :2] + 37.5) / 18.75
    inner = (np.abs(place - np.round(place)) > 0.05).all(axis=1)
    bright = (np.floor(place).astype(int).sum(axis=1) % 2 == 1)[inner]
    ratio = (found.intensity / white.intensity)[inner]
    assert np.ptp(ratio[bright]) < 1e-3
    assert np.ptp(ratio[~bright]) < 1e-3
    expected = ((235 / 255 + 0.055) / (118 / 255 + 0.055)) ** 2.4
    assert ratio[bright].mean() / ratio[~bright].mean() == pytest.approx(expected, rel=1e-3)


def test_the_first_row_of_an_image_is_on_top():
    image = np.array([[0.1, 0.2], [0.3, 0.4]])
    at = albedo.bilinear(image, np.array([[0.25, 0.75], [0.75, 0.25], [0.5, 0.5], [1.25, -0.25]]))
    assert at == pytest.approx([0.1, 0.4, 0.25, 0.1])


def test_colours_survive_faces_that_look_inward(plate):
    """Such a mesh is turned before it is scanned."""
    config = ScannerConfig(views=((0, 0, 1),), resolution=(80, 80), bits=0, material="colours")
    uv = np.random.default_rng(0).random((len(plate.vertices), 2))
    image = np.tile(np.arange(100, 256, dtype=np.uint8)[:, None, None], (1, 8, 3))
    inward = replace(plate, faces=np.ascontiguousarray(plate.faces[:, [0, 2, 1]]))
    found = [
        scan(shape, config, attributes={"texture": Texture.of_vertices(image, uv, shape.faces)})
        for shape in (plate, inward)
    ]
    assert np.allclose(found[0].intensity, found[1].intensity, atol=1e-6)


@pytest.mark.parametrize(
    ("name", "value", "words"),
    [
        (None, None, "needs the colours of the mesh"),
        ("vertex_colour", np.zeros(3), "finite value"),
        ("texture", np.zeros((4, 4, 3)), "must be a Texture"),
        ("face_colour", np.full((12, 3), 2.0), r"0\.\.1"),
        ("face_colour", np.ones((12, 2)), "red, green and blue"),
    ],
)
def test_colours_that_cannot_be_used_are_one_line(plate, name, value, words):
    config = ScannerConfig(**SMALL, material="colours")
    with pytest.raises(InputError, match=words) as caught:
        Rig(plate, config, {name: value} if name else {})
    assert "\n" not in str(caught.value)


def test_light_that_bounces_is_not_coloured(plate):
    config = ScannerConfig(**SMALL, material="colours", bounces=2, falloff="inverse_square")
    with pytest.raises(InputError, match="bounces = 1"):
        Rig(plate, config, {"face_colour": np.ones((12, 3))})
