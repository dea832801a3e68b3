"""One clear line for everything that cannot be scanned."""

import logging
import re
from dataclasses import replace

import numpy as np
import pytest
import trimesh

from datasets_gen import InputError, Shape
from scanner_sim import ScannerConfig, coverage, sample, scan, write_contact_sheet
from tests.scanner_sim.conftest import to_shape

SMALL = {"views": 2, "resolution": (60, 60)}


@pytest.mark.parametrize(
    ("setting", "word"),
    [
        ({"peak_threshold": 0.0}, "peak_threshold"),
        ({"peak_threshold": 1.5}, "peak_threshold"),
        ({"peak_threshold": "high"}, "peak_threshold"),
        ({"baseline": 0.0}, "baseline"),
        ({"min_range": 300.0, "max_range": 70.0}, "max_range"),
        ({"min_range": -1.0}, "min_range"),
        ({"field_of_view": 180.0}, "field_of_view"),
        ({"field_of_view": 0}, "field_of_view"),
        ({"distortion": (-5.0, 0.0)}, "distortion"),
        ({"views": 0}, "views"),
        ({"views": "dome"}, "views"),
        ({"stripes": 20}, "stripes"),
        ({"stripes": 100.5}, "stripes"),
        ({"resolution": (4, 4)}, "resolution"),
        ({"resolution": 400}, "resolution"),
        ({"bits": 17}, "bits"),
        ({"noise": 1.5}, "noise"),
        ({"gain": 0}, "gain"),
        ({"exposure": float("inf")}, "exposure"),
        ({"fit": "cubic"}, "fit"),
        ({"normals": "voxel"}, "normals"),
        ({"realign": 1}, "realign"),
        ({"bounces": 2}, "bounces"),
        ({"distance": 0.0}, "distance"),
    ],
)
def test_impossible_settings_are_named(setting, word):
    with pytest.raises(InputError, match=word) as caught:
        ScannerConfig(**setting)
    assert "\n" not in str(caught.value)


def test_unknown_settings_are_named_with_the_known_ones():
    with pytest.raises(InputError, match=r"treshold.*peak_threshold"):
        ScannerConfig.from_dict({"treshold": 0.1})


def test_settings_survive_toml_and_json(capsule):
    import json
    import tomllib
    from dataclasses import asdict

    text = (
        'views = [[1, 0, 0], [0, 0, 1]]\nresolution = [60, 50]\nmaterial = {type = "plastic", int_ior = 1.4}'
    )
    config = ScannerConfig.from_dict(tomllib.loads(text))
    assert config.views == ((1, 0, 0), (0, 0, 1))
    assert ScannerConfig.from_dict(json.loads(json.dumps(asdict(config)))) == config
    assert hash(config) == hash(replace(config))


@pytest.mark.parametrize("tau", [0, -1, 1.01, float("nan")])
def test_accept_refuses_thresholds_outside_its_range(capsule, tau):
    with pytest.raises(InputError, match="threshold"):
        sample(capsule, 10).accept(tau)


def test_unusable_shapes_are_refused(capsule):
    broken = capsule.vertices.copy()
    broken[0] = np.nan
    for shape, word in (
        (replace(capsule, vertices=broken), "finite"),
        (replace(capsule, faces=capsule.faces[:0]), "faces"),
        (replace(capsule, vertices=np.ones_like(capsule.vertices)), "extent"),
    ):
        with pytest.raises(InputError, match=word):
            scan(shape)


def test_cameras_and_lasers_inside_the_object_are_refused():
    bowl = to_shape(trimesh.creation.icosphere(subdivisions=3, radius=37.5))
    with pytest.raises(InputError, match="camera of view 0 stands inside"):
        scan(bowl, ScannerConfig(**SMALL, distance=20.0))
    balls = [trimesh.creation.icosphere(radius=10.0) for _ in range(2)]
    for ball, x in zip(balls, (-27.5, 27.5), strict=True):
        ball.apply_translation([x, 0, 0])
    between = ScannerConfig(views=((0, 0, 1),), distance=3.0, baseline=27.5, min_range=1.0)
    with pytest.raises(InputError, match="laser of view 0 stands inside"):
        scan(to_shape(trimesh.util.concatenate(balls)), between)


def test_objects_outside_the_range_are_refused(capsule):
    with pytest.raises(InputError, match=re.escape("outside the swept 70..300 mm")):
        scan(capsule, ScannerConfig(**SMALL, distance=500.0))


def test_a_view_that_sees_nothing_is_logged_and_the_scan_goes_on(caplog):
    sheet = Shape(
        np.array([[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0]], float),
        np.array([[0, 1, 2], [0, 2, 3]], np.int32),
        "a/sheet", "a", "sheet",
    )  # fmt: skip
    front = scan(sheet, ScannerConfig(views=((0, 0, 1),), resolution=(60, 60)))
    with caplog.at_level(logging.WARNING):
        both = scan(sheet, ScannerConfig(views=((0, 0, -1), (0, 0, 1)), resolution=(60, 60)))
    assert "1 of 2 views see nothing of it: [0]" in caplog.text
    assert set(both.view_ids) == {1}
    assert np.array_equal(both.pixels, front.pixels)
    with pytest.raises(InputError, match=r"none of 1 view sees .* backs of its faces"):
        scan(sheet, ScannerConfig(views=((0, 0, -1),), resolution=(60, 60)))


@pytest.mark.parametrize(
    ("settings", "reason"),
    [
        ({"peak_threshold": 1.0}, "too obliquely for peak_threshold 1; lower peak_threshold"),
        ({"material": "black", "peak_threshold": 0.3}, "too little light .* raise exposure"),
        ({"exposure": 200.0}, "saturate the sensor; lower exposure"),
        ({"depth_threshold": 1e-9}, "no clean peak"),
        ({"distance": 500.0}, "outside the swept 70..300 mm; change distance"),
    ],
)
def test_what_acquires_nothing_says_why(plate, settings, reason):
    """A plate seen face on: the cosine to the laser is .55 and more everywhere, and nothing is hidden."""
    face_on = {"views": ((0, 0, 1),), "resolution": (60, 60), "shading": "flat"}
    with pytest.raises(InputError, match=reason) as caught:
        scan(plate, ScannerConfig(**face_on, **settings))
    hits, total = re.search(r"([\d,]+) of ([\d,]+) hits", str(caught.value)).groups()
    assert hits == total
    assert "\n" not in str(caught.value)


def test_the_reason_for_nothing_is_the_leading_one(capsule):
    """Of a black capsule at .9, most of what the camera sees is too oblique even if it were white."""
    with pytest.raises(InputError, match=r"too obliquely .* \(also [\d,]+ dark\)"):
        scan(capsule, ScannerConfig(**SMALL, material="black", peak_threshold=0.9))


def test_a_view_that_acquires_nothing_is_logged(plate, caplog):
    config = ScannerConfig(
        views=((0, 0, 1), (1, 0, 0)), resolution=(60, 60), shading="flat", peak_threshold=0.9
    )
    with caplog.at_level(logging.WARNING):
        found = scan(plate, config)
    assert set(found.view_ids) == {0}
    assert "acquired no point: [1]" in caplog.text


def test_flipped_winding_is_detected_and_said(capsule, caplog):
    config = ScannerConfig(**SMALL)
    flipped = replace(capsule, faces=np.ascontiguousarray(capsule.faces[:, ::-1]))
    with caplog.at_level(logging.WARNING):
        found = scan(flipped, config)
    assert "look inward" in caplog.text
    straight = scan(capsule, config)
    assert np.array_equal(found.points, straight.points)
    assert np.allclose(found.normals, straight.normals)
    assert np.allclose(flipped.at(found.face_ids, found.barycentrics), found.true_points)


@pytest.mark.parametrize("scale", [1e-7, 1e8])
def test_strange_units_are_scanned_alike_and_warned_of_once(capsule, caplog, scale):
    config = ScannerConfig(**SMALL)
    strange = replace(capsule, vertices=capsule.vertices * scale, subject=f"strange{scale}")
    with caplog.at_level(logging.WARNING):
        found = scan(strange, config)
        scan(strange, config)
    assert caplog.text.count("the rig is scaled") == 1
    nameless = replace(strange, subject=f"nameless{scale}", units="unknown")
    with caplog.at_level(logging.WARNING):
        scan(nameless, config)
    assert f"measures {75 * scale:.3g} in unknown units" in caplog.text
    plain = scan(capsule, config)
    assert abs(len(found) - len(plain)) <= 3
    assert np.sqrt(((found.points - found.true_points) ** 2).sum(axis=1).mean()) * found.scale < 0.02


def test_bad_arguments_of_helpers(capsule, tmp_path):
    whole = sample(capsule, 100)
    with pytest.raises(InputError, match="at least 1"):
        sample(capsule, 0)
    with pytest.raises(InputError, match="at least 1"):
        whole.subsample(0)
    with pytest.raises(InputError, match="radius"):
        coverage(whole, capsule, radius=0)
    with pytest.raises(InputError, match="no view"):
        write_contact_sheet(capsule, tmp_path / "x.png", ScannerConfig(**SMALL), view=-1)


def test_coverage_counts_area_not_points(plate):
    """Only the upper side sampled: half the area of the large sides, whatever the number of points."""
    whole = sample(plate, 4000, shading="flat")
    upper = whole.select(whole.points[:, 2] > 2.49)
    sides = 2 * 75 * 75 / (2 * 75 * 75 + 4 * 75 * 5)
    assert coverage(whole, plate, radius=3.0) == 1
    assert coverage(upper, plate, radius=2.0) == pytest.approx(sides / 2 + (1 - sides) * 2 / 5, abs=0.02)
    assert coverage(whole.select(np.zeros(4000, bool)), plate) == 0


def test_subsample_of_few_points_and_of_one(capsule):
    whole = sample(capsule, 40)
    for n in (1, 2, 39):
        thin = whole.subsample(n, seed=1)
        assert len(np.unique(thin.points, axis=0)) == n
    assert len(sample(capsule, 1)) == 1


def test_subsample_chooses_by_the_surface_not_by_the_fits(sphere):
    whole = sample(sphere, 3000, seed=1)
    noise = np.random.default_rng(2).normal(scale=1e-3, size=whole.points.shape)
    moved = replace(whole, points=whole.points + noise)
    assert np.array_equal(whole.subsample(500, seed=4).face_ids, moved.subsample(500, seed=4).face_ids)


def test_a_threshold_below_that_of_the_scan_is_refused(capsule):
    found = scan(capsule, ScannerConfig(**SMALL, peak_threshold=0.5))
    with pytest.raises(InputError, match=r"below the 0\.5"):
        found.accept(0.3)


@pytest.mark.parametrize("seed", [-1, 1.5, "a", None])
def test_a_seed_that_is_no_whole_number_is_refused(capsule, seed):
    with pytest.raises(InputError, match="seed"):
        scan(capsule, ScannerConfig(**SMALL), seed)
    with pytest.raises(InputError, match="seed"):
        sample(capsule, 10, seed)


@pytest.mark.parametrize(
    "settings",
    [
        {"smoothing": 0.5, "fit": "least_squares"},
        {"smoothing": 1.0},
        {"smoothing": 0.5, "smoothing_stage": "image"},
    ],
)
def test_smoothing_of_what_is_partly_out_of_range_measures_the_rest(sphere, settings):
    """Of a sphere seen at 42.5 to 68.7 mm, what is nearer than 55 mm is too near to be swept."""
    rig = {"views": ((0, 0, 1),), "resolution": (60, 60), "stripe_width": 5.0, "distance": 80.0}
    whole, part = (scan(sphere, ScannerConfig(**rig, **settings, min_range=least)) for least in (40.0, 55.0))
    reach = [np.linalg.norm(each.true_points - each.poses[0, :3, 3], axis=1) for each in (whole, part)]
    assert reach[0].min() < 44
    assert reach[1].min() == pytest.approx(55, abs=0.5)
    assert len(part) == pytest.approx((reach[0] > 55).sum(), rel=0.15)
    assert np.abs(np.linalg.norm(part.points, axis=1) - 37.5).max() < 1


def test_a_footprint_that_sees_nothing_is_refused_like_a_single_ray(sphere):
    away = np.eye(4)
    away[:3, :3], away[:3, 3] = np.diag([1, -1, -1]), (4000, 0, 200)
    for footprint in (1, 3):
        with pytest.raises(InputError, match="outside their images"):
            scan(sphere, ScannerConfig(views=[away.tolist()], footprint=footprint))


def test_a_pixel_gives_one_point_whatever_lights_it(torus):
    config = ScannerConfig(
        views="ring:3",
        resolution=(8, 8),
        stripe_width=3.0,
        footprint=3,
        fit="centre_of_mass",
        field_of_view=120.0,
        peak_threshold=0.01,
    )
    found = scan(torus, config)
    assert len(np.unique(np.column_stack([found.view_ids, found.pixels]), axis=0)) == len(found)


def test_a_distorting_lens_sees_as_much_of_a_coarse_mesh_as_of_a_fine_one():
    box = trimesh.creation.box((1, 1, 0.01))
    config = ScannerConfig(
        views=((0, 0, 1),),
        distortion=(-0.29, 0.0),
        distance=125.0,
        max_range=400.0,
        object_size=300.0,
        resolution=(60, 60),
        stripe_width=5.0,
    )
    counts = [len(scan(to_shape(mesh, "a/box"), config)) for mesh in (box, box.subdivide().subdivide())]
    assert counts[0] == pytest.approx(counts[1], rel=0.02)
