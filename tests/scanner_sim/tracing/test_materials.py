import numpy as np
import pytest

from datasets_gen import InputError
from scanner_sim import MATERIALS, ScannerConfig, scan
from scanner_sim.scanner import Rig
from scanner_sim.tracing.tracer import Tracer

SMALL = {"views": 2, "resolution": (60, 60)}


def radiance(shape, material, attributes=None, **settings):
    rig = Rig(shape, ScannerConfig(**SMALL, material=material, **settings), attributes)
    return rig.tracer.view(rig.poses[0])


def test_albedo_scales_a_diffuse_surface(capsule, each_variant):
    white, gray = radiance(capsule, "white"), radiance(capsule, "gray")
    assert np.allclose(gray.radiance, 0.5 * white.radiance, atol=1e-5)


def test_gain_makes_up_for_albedo(capsule):
    white = scan(capsule, ScannerConfig(**SMALL, bits=0))
    gray = scan(capsule, ScannerConfig(**SMALL, bits=0, material="gray", gain=2.0))
    assert len(white) == len(gray)
    assert np.allclose(white.intensity, gray.intensity, atol=1e-4)


@pytest.mark.parametrize("name", [n for n in MATERIALS if "albedo" not in n and n != "colours"])
def test_every_named_material_returns_light(capsule, name):
    seen = radiance(capsule, name)
    assert np.isfinite(seen.radiance).all()
    assert (seen.radiance >= 0).all()
    assert (seen.radiance > 1e-4).mean() > 0.2


def test_glossy_lobe_is_mitsubas_own(plate, each_variant):
    """On a flat plate: the value of the BSDF for the two directions, times the cosine."""
    import mitsuba as mi

    from scanner_sim.tracing import variant

    table = {"type": "roughconductor", "alpha": 0.4}
    config = ScannerConfig(views=((0.1, 0, 1),), resolution=(30, 30), shading="flat", material=table)
    rig = Rig(plate, config)
    hits = rig.tracer.view(rig.poses[0])
    front = np.flatnonzero(hits.radiance > 0)[::37]
    world = hits.points[front] @ rig.poses[0][:3, :3].T
    eye = -world
    laser = config.baseline * rig.poses[0][:3, 0] - world
    on_front = world[:, 2] + rig.poses[0][2, 3] > 2.4
    assert on_front.sum() > 10
    with variant.active(variant.SCALAR):
        surface = mi.load_dict(table)
        for k, i in zip(np.flatnonzero(on_front), front[on_front], strict=True):
            record = mi.SurfaceInteraction3f()
            record.wi = (eye[k] / np.linalg.norm(eye[k])).tolist()
            wanted = (laser[k] / np.linalg.norm(laser[k])).tolist()
            value = surface.eval(mi.BSDFContext(), record, mi.Vector3f(wanted))[0] * np.pi
            assert hits.radiance[i] == pytest.approx(value, rel=2e-3)


def test_albedo_per_vertex_and_per_face(capsule, each_variant):
    rng = np.random.default_rng(0)
    white = radiance(capsule, "white")
    per_face = rng.uniform(0.2, 1, len(capsule.faces))
    by_face = radiance(capsule, "face_albedo", {"face_albedo": per_face})
    assert np.allclose(by_face.radiance, per_face[by_face.face_ids] * white.radiance, atol=2e-3)
    per_vertex = rng.uniform(0.2, 1, len(capsule.vertices))
    by_vertex = radiance(capsule, "vertex_albedo", {"vertex_albedo": per_vertex})
    albedo = (per_vertex[capsule.faces[by_vertex.face_ids]] * by_vertex.barycentrics).sum(axis=1)
    assert np.allclose(by_vertex.radiance, albedo * white.radiance, atol=5e-3)


def test_image_texture_by_texture_coordinates(capsule, tmp_path):
    """Left half black: dark by the texture where u < 0.5."""
    from PIL import Image

    picture = np.full((4, 64), 255, np.uint8)
    picture[:, :32] = 0
    Image.fromarray(picture).save(tmp_path / "half.png")
    x = capsule.vertices[:, 0]
    uv = np.stack([(x - x.min()) / np.ptp(x), np.full_like(x, 0.5)], axis=1)
    bitmap = {"type": "bitmap", "filename": str(tmp_path / "half.png"), "raw": True, "filter_type": "nearest"}
    seen = radiance(capsule, {"type": "diffuse", "reflectance": bitmap}, {"vertex_uv": uv})
    plain = radiance(capsule, "white")
    u = (uv[capsule.faces[seen.face_ids], 0] * seen.barycentrics).sum(axis=1)
    assert (seen.radiance[u < 0.49] == 0).all()
    assert np.allclose(seen.radiance[u > 0.51], plain.radiance[u > 0.51], atol=1e-4)


def test_two_materials_by_face(capsule):
    """Mitsuba's blend with a weight of 0 or 1 per face."""
    which = (np.arange(len(capsule.faces)) % 2).astype(float)
    material = {
        "type": "blendbsdf",
        "weight": {"type": "mesh_attribute", "name": "face_second"},
        "first": dict(MATERIALS["white"]),
        "second": dict(MATERIALS["metal"]),
    }
    mixed = radiance(capsule, material, {"face_second": which})
    white, metal = radiance(capsule, "white"), radiance(capsule, "metal")
    expected = np.where(which[mixed.face_ids] > 0, metal.radiance, white.radiance)
    assert np.allclose(mixed.radiance, expected, rtol=1e-3, atol=1e-4)


@pytest.mark.parametrize(
    ("material", "words"),
    [
        ("wood", "known are white"),
        ({"type": "wood"}, "no Mitsuba BSDF"),
        ({"type": "sphere"}, "no Mitsuba BSDF"),
        ({"type": "diffuse", "colour": 1.0}, "no Mitsuba BSDF"),
        ({"type": "conductor"}, "mirrors"),
        ({"type": "dielectric"}, "mirrors"),
    ],
)
def test_unusable_materials_are_one_line(capsule, material, words):
    with pytest.raises(InputError, match=words) as caught:
        Tracer(capsule, ScannerConfig(material=material))
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    "attributes",
    [
        {"albedo": np.ones(3)},
        {"vertex_albedo": np.ones(3)},
        {"face_x": np.ones((2, 2, 2))},
        {"vertex_uv": np.ones(5)},
    ],
)
def test_attributes_that_do_not_fit_are_refused(capsule, attributes):
    with pytest.raises(InputError, match="attribute"):
        Tracer(capsule, ScannerConfig(), attributes=attributes)


def test_material_without_its_attribute_is_refused(capsule):
    with pytest.raises(InputError, match="face_albedo"):
        scan(capsule, ScannerConfig(**SMALL, material="face_albedo"))
