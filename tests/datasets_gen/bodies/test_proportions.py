import numpy as np
import pytest

from datasets_gen.bodies import human, quadruped
from datasets_gen.bodies.implicit_surface import Body, ellipsoid, sweep
from datasets_gen.bodies.proportions import (
    FLIP,
    Affine,
    Region,
    mirrored,
    random_scales,
    region_maps,
    scaled_part,
    side_regions,
)

POINTS = np.random.default_rng(0).uniform(-1, 1, (400, 3))
PART = sweep(
    "arm.L", (0.1, 0.2, 0.3), (0.6, 0.1, 0.2), [(0, 0.1, 0.2, 0.03, 0.01), (1, 0.2, 0.1)], caps=(0.1, 0.05),
    blend=0.02, power=2.4,
)  # fmt: skip


def distance(part, points):
    return Body((part,)).distances(points)[0]


@pytest.mark.parametrize(
    "part", [PART, ellipsoid("leg.L", (0.2, 0, 0.1), (0.1, 0.3, 0.2), blend=0.1, axis=(1, 2, 0))]
)
def test_mirror_image_has_the_mirrored_field(part):
    assert distance(mirrored(part), POINTS * FLIP) == pytest.approx(distance(part, POINTS))
    assert distance(mirrored(mirrored(part)), POINTS) == pytest.approx(distance(part, POINTS))
    assert mirrored(part).bones[0].endswith(".R")
    assert np.linalg.det(mirrored(part).axes) == pytest.approx(1)


def test_uniform_scaling_scales_the_field():
    by = Affine(1.3 * np.eye(3), np.array([0.1, -0.2, 0.4]))
    scaled = np.array([by(p) for p in POINTS])
    assert distance(scaled_part(PART, by), scaled) == pytest.approx(1.3 * distance(PART, POINTS))


def test_stretching_along_the_axis_keeps_the_girth():
    part = sweep("b", (0, 0, 0), (0, 1, 0), [(0, 0.1, 0.2), (1, 0.1, 0.2)], caps=(0.1, 0.1), blend=0.02)
    longer = scaled_part(part, Affine(np.diag([1, 2.0, 1]), np.zeros(3)))
    assert longer.length == pytest.approx(2)
    assert longer.profile == pytest.approx(part.profile)


REGIONS = side_regions(
    {
        "arm.L": Region(None, np.array([0.2, 1.4, 0]), np.array([1.0, 0, 0]), ("upper.L",)),
        "hand.L": Region("arm.L", np.array([0.7, 1.4, 0]), np.array([1.0, 0, 0]), ("hand.L",)),
    }
)


def test_regions_stretch_about_their_anchor_and_carry_their_children():
    maps = region_maps(REGIONS, {"arm.L": (1.2, 0.5)})
    assert maps["arm.L"](np.array([0.2, 1.4, 0])) == pytest.approx((0.2, 1.4, 0))
    assert maps["arm.L"](np.array([0.7, 1.5, 0])) == pytest.approx((0.8, 1.45, 0))
    assert maps["hand.L"](np.array([0.7, 1.5, 0])) == pytest.approx((0.8, 1.5, 0))  # moved, not scaled
    assert maps["hand.R"](np.array([-0.7, 1.5, 0])) == pytest.approx((-0.7, 1.5, 0))


def test_seeds_give_symmetric_proportions_near_the_default():
    assert random_scales(REGIONS, 0) == {}
    scales = random_scales(REGIONS, 5)
    assert scales == random_scales(REGIONS, 5)
    assert scales != random_scales(REGIONS, 6)
    assert scales["arm.L"] == scales["arm.R"] != scales["hand.L"]
    assert all(0.93 <= length <= 1.07 and 0.9 <= girth <= 1.1 for length, girth in scales.values())


@pytest.mark.parametrize(
    ("regions", "plan"), [(human.regions, human.plan), (quadruped.regions, quadruped.plan)]
)
def test_every_bone_has_one_region(regions, plan):
    bones = [bone for region in regions().values() for bone in region.bones]
    assert sorted(bones) == sorted(bone.name for bone in plan().skeleton.bones)


@pytest.mark.parametrize("plan", [human.plan, human.asymmetric_plan, quadruped.plan])
def test_plans_refer_to_bones_that_exist(plan):
    body = plan(3)
    names = {bone.name for bone in body.skeleton.bones}
    assert {bone for part in body.surface.parts for bone in part.bones} <= names
    assert {detail.bone for detail in body.details} <= names
    assert len(body.poses) >= 8
    for pose in body.poses.values():
        body.skeleton.transforms(pose)


@pytest.mark.parametrize("plan", [human.plan, quadruped.plan])
def test_symmetric_bodies_have_a_symmetric_field(plan):
    body = plan(2).surface
    lower, upper = body.bounds()
    points = np.random.default_rng(0).uniform(lower, upper, (4000, 3))
    near = points[np.abs(body(points)) < 0.05]
    assert body(near * FLIP) == pytest.approx(body(near), abs=6e-3)  # sides join in another order
