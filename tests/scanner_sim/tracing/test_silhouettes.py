"""Grazing silhouettes of coarse meshes: the geometry says what is seen and lit."""

import numpy as np
import pytest
import trimesh

from datasets_gen.meshes.geometry import face_normals
from scanner_sim import ScannerConfig
from scanner_sim.scanner import Rig
from scanner_sim.tracing import variant
from tests.scanner_sim.conftest import to_shape, usable

COARSE = {
    "sphere": trimesh.creation.icosphere(subdivisions=1, radius=37.5),
    "cylinder": trimesh.creation.cylinder(radius=20.0, height=75.0, sections=9),
}
CONFIG = {"views": 3, "resolution": (100, 100)}


def seen(shape, **settings):
    """Hits of all views, with the normals of their faces, in camera coordinates."""
    rig = Rig(shape, ScannerConfig(**CONFIG, **settings))
    facets = face_normals(shape.vertices, shape.faces)
    for pose in rig.poses:
        hits = rig.tracer.view(pose)
        yield hits, facets[hits.face_ids] @ pose[:3, :3]


@pytest.mark.parametrize("name", COARSE)
def test_whatever_is_visible_and_lit_returns_light(name, each_variant):
    """On a convex body no point is in another's shadow: a facet that faces camera and laser is lit."""
    for hits, facets in seen(to_shape(COARSE[name])):
        toward = np.array([50.0, 0, 0]) - hits.points
        cosine = np.einsum("nd,nd->n", facets, toward) / np.linalg.norm(toward, axis=1)
        assert np.einsum("nd,nd->n", facets, hits.points).max() < 0  # all hits are on fronts
        assert (hits.radiance[cosine > 1e-4] > 0).mean() == 1
        assert (hits.radiance[cosine < 0] == 0).all()
        assert (np.einsum("nd,nd->n", hits.normals, hits.points)[hits.radiance > 0] < 0).all()


def test_the_light_there_is_that_of_the_facets(each_variant):
    """White and diffuse: the cosine between the normal that is reported and the direction to the laser."""
    bent = 0
    for hits, facets in seen(to_shape(COARSE["sphere"])):
        toward = np.array([50.0, 0, 0]) - hits.points
        toward /= np.linalg.norm(toward, axis=1, keepdims=True)
        lit = hits.radiance > 0
        cosine = np.einsum("nd,nd->n", hits.normals, toward)
        assert hits.radiance[lit] == pytest.approx(cosine[lit], abs=1e-4)
        bent += (np.abs(hits.normals - facets).max(axis=1) < 1e-12)[lit].sum()
    assert bent > 100


def test_smooth_and_flat_shading_see_the_same_silhouette(each_variant):
    shape = to_shape(COARSE["cylinder"])
    for (smooth, _), (flat, _) in zip(seen(shape), seen(shape, shading="flat"), strict=True):
        assert np.array_equal(smooth.pixels, flat.pixels)
        assert np.array_equal(smooth.radiance > 0, flat.radiance > 0)


def test_variants_agree_on_every_pixel(monkeypatch):
    """A glossy surface, whose light follows the normal closely, seen through a distorting lens."""
    found = {}
    for name in (variant.SCALAR, usable(variant.LLVM)):
        monkeypatch.setattr(variant, "choose", lambda name=name: name)
        settings = {"material": "plastic", "distortion": (0.05, 0.0)}
        found[name] = list(seen(to_shape(COARSE["sphere"]), **settings))
    for (one, _), (other, _) in zip(*found.values(), strict=True):
        assert np.array_equal(one.pixels, other.pixels)
        assert one.radiance == pytest.approx(other.radiance, abs=2e-3)
