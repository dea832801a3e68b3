"""The public face: the README's example, and what its calls take and refuse."""

import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import trimesh
from PIL import Image
from scipy.spatial import cKDTree

import medialbench as mb
from datasets_gen import as_shape
from datasets_gen.records import save_record
from tests.little_matching import AS_OPTIONS, CHEAP

SMALL = {"views": 4, "resolution": (60, 60), "stripes": 80}
SIZE = {"modes": 30, "points": 400}
FAST = {**SIZE, "config": CHEAP}


def bent_club(bend):
    """A closed surface, symmetric in z alone."""
    mesh = trimesh.creation.icosphere(subdivisions=3)
    v = np.array(mesh.vertices) * [0.5, 1.5, 0.4]
    v[:, 0] += 0.25 * v[:, 1] ** 2 + 0.1 * v[:, 1] + bend * v[:, 1] ** 2
    v[:, 2] *= 1 + 0.4 * np.tanh(v[:, 1])
    return trimesh.Trimesh(v, mesh.faces, process=False)


@pytest.fixture(scope="module")
def body(tmp_path_factory):
    folder = tmp_path_factory.mktemp("club")
    bent_club(0.0).export(folder / "rest.ply")
    bent_club(0.1).export(folder / "bent.ply")
    return mb.load(folder)


@pytest.fixture(scope="module")
def scans(body):
    return tuple(mb.scan(body[pose], threshold=0.3, points=600, **SMALL) for pose in ("rest", "bent"))


@pytest.fixture(scope="module")
def found(scans):
    return mb.match(*scans, **FAST)


def drawn(figure):
    return [axes for axes in figure.axes if axes.get_images()]


def straight_errors(image, a, b, body):
    """Straight distances on the rest pose between found and right place, x 100 / sqrt(area)."""
    here, there = (body.reference.at(each.face_ids, each.barycentrics) for each in (a, b))
    return 100 * np.linalg.norm(there[image] - here, axis=1) / np.sqrt(body.reference.area)


def test_it_imports_fast_and_without_heavy_libraries():
    code = (
        "import sys, time; t = time.perf_counter(); import medialbench;assert time.perf_counter() - t < "
        "0.3;heavy = ('numpy', 'scipy', 'numba', 'mitsuba', 'pandas', 'matplotlib', 'dask');print([m for "
        "m in heavy if m in sys.modules])"
    )
    found = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert found.stdout.strip() == "[]"


def test_every_name_is_there_and_documented():
    assert set(dir(mb)) == set(mb.__all__)
    for name in mb.__all__:
        assert getattr(mb, name).__doc__
    assert mb.__version__.count(".") == 2
    with pytest.raises(AttributeError, match=r"'mach'.*match"):
        mb.mach  # noqa: B018


def test_the_first_hour(body, scans, tmp_path):
    """Load, scan two poses, match, an error in one call, a picture in one call."""
    a, b = scans
    found = mb.match(a, b, **SIZE)
    assert found.source_to_target.shape == found.confidence.shape == (600,)
    errors = mb.geodesic_error(found, a, b, body)
    straight = straight_errors(found.source_to_target, a, b, body)
    assert straight.mean() < 6  # of a random map 42
    assert (errors >= straight - 1e-9).all()
    assert errors.mean() < 1.1 * straight.mean()
    told = mb.score(found, a, b, body)
    np.testing.assert_allclose(100 * told.errors, errors)
    assert 0 < 100 * told.least < errors.mean()
    assert told.right_limb == 1.0  # of the club's two ends
    assert told.mirror_limb in (None, 0.0)
    mb.plot(found, a, b).savefig(tmp_path / "map.png")
    assert (tmp_path / "map.png").read_bytes()[:4] == b"\x89PNG"


# ---------------------------------------------------------------------------- scan, sample


def test_scan_takes_a_shape_a_path_a_trimesh_and_arrays(body, tmp_path):
    mesh = bent_club(0.0)
    mesh.export(tmp_path / "mesh.ply")
    shape = body["rest"]
    given = (shape, tmp_path / "mesh.ply", str(tmp_path / "mesh.ply"), mesh, (mesh.vertices, mesh.faces))
    sizes = [len(mb.scan(each, threshold=0.3, **SMALL)) for each in given]
    assert min(sizes) > 500
    assert max(sizes) - min(sizes) < 0.02 * max(sizes)  # files hold single precision


def test_a_scan_says_in_one_line_what_it_is(scans):
    assert repr(scans[0]).endswith("/rest': 600 points, 4 views)")


def test_a_scan_has_the_settings_that_were_asked_for(scans):
    config = scans[0].config
    assert (config.peak_threshold, config.views, config.resolution) == (0.3, 4, (60, 60))
    assert len(scans[0]) == 600


def test_samples_miss_nothing(body):
    """Even samples: neighbours are at least half a spacing apart, and no place is without a sample."""
    shape, cloud = body["rest"], mb.sample(body["rest"], 500)
    assert len(cloud) == 500
    assert np.allclose(shape.at(cloud.face_ids, cloud.barycentrics), cloud.points)
    spacing, tree = np.sqrt(shape.area / 500), cKDTree(cloud.points)
    assert tree.query(cloud.points, k=2)[0][:, 1].min() > 0.5 * spacing
    assert tree.query(shape.vertices)[0].max() < 1.5 * spacing


# ---------------------------------------------------------------------------- match, symmetry


def test_maps_of_arrays_cover_all_points(body, scans, found):
    a, b = scans
    for source, target in (
        ((a.points, a.normals), (b.points, b.normals)),
        ([a.points, a.normals], b),
    ):
        same = mb.match(source, target, **FAST)
        assert np.array_equal(same.source_to_target, found.source_to_target)
    bare = mb.match(a.points, b.points, **FAST)  # normals are estimated
    assert straight_errors(bare.source_to_target, a, b, body).mean() < 6


def test_maps_of_files_are_those_of_scans_and_of_the_command_line(scans, found, tmp_path):
    from click.testing import CliRunner

    from reports.cli.main import cli

    files = [tmp_path / "a.npz", tmp_path / "b.npz"]
    for scan, file in zip(scans, files, strict=True):
        scan.save(file)
    by_path = mb.match(str(files[0]), files[1], **FAST)
    assert np.array_equal(by_path.source_to_target, found.source_to_target)
    out = tmp_path / "map.npz"
    arguments = ["match", *map(str, files), "-o", str(out), "--modes", "30", "--points", "400"]
    arguments += AS_OPTIONS
    assert CliRunner().invoke(cli, arguments).exit_code == 0
    read = mb.Matching.load(out)
    for name in ("source_to_target", "confidence", "landmarks", "source_points", "target_points"):
        assert np.array_equal(getattr(read, name), getattr(found, name)), name


def test_a_diffusion_is_matched_whole_and_decides_the_operator(body, scans):
    a, b = scans
    diffusion = mb.Diffusion.from_points(a.points, a.normals, operator="heat", modes=30)
    mixed = mb.match(diffusion, b, points=400, config=CHEAP)
    other = mb.Diffusion.from_points(b.points, b.normals, operator="heat", modes=30)
    assert straight_errors(mixed.source_to_target, a, b, body).mean() < 4
    assert straight_errors(mb.match(diffusion, other, config=CHEAP).source_to_target, a, b, body).mean() < 4


def test_symmetry_maps_a_cloud_to_itself(scans):
    found = mb.symmetry(scans[0], **FAST)
    assert found.source_to_target.shape == (600,)
    assert np.array_equal(found.source_points, found.target_points)


def test_pairs_of_vertices_and_faces_are_meshes(scans):
    """Integer normals are none, although they are integers."""
    mesh = bent_club(0.0)
    found = mb.match((mesh.vertices, mesh.faces), scans[1], **FAST)
    assert len(found) == FAST["points"]
    grid = np.stack(np.meshgrid(np.arange(6.0), np.arange(6.0), [0.0]), -1).reshape(-1, 3)
    assert (
        len(mb.match((grid, np.tile([0, 0, 1], (36, 1))), scans[1], modes=10, points=400, config=CHEAP)) == 36
    )


def test_settings_that_nothing_has_are_named(scans):
    with pytest.raises(mb.InputError, match=r"setting 'sigma'; .*sigma_e"):
        mb.match(*scans, **FAST, sigma=3)
    for call in (mb.match, mb.symmetry):
        with pytest.raises(mb.InputError, match="match config is 'papr'"):
            call(None, **({"target": None} if call is mb.match else {}), config="papr")  # before anything


def test_small_clouds_take_the_modes_that_they_have(scans, caplog):
    found = mb.match(scans[0], scans[1].subsample(200), modes=300, points=400, config=CHEAP)
    assert len(found) == len(scans[0])
    assert "200 places carry 199 modes, not 300: so many are taken" in caplog.text


@pytest.mark.parametrize(("count", "lengths"), [(1, 1e4), (3, 10), (20, 1e6)])
def test_stray_points_change_nothing_for_the_others(scans, found, count, lengths, caplog):
    """One point 10,000 body lengths away once made 97 % of a map wrong and confident."""
    away = np.random.default_rng(count).normal(size=(count, 3))
    away *= lengths * np.ptp(scans[0].points, axis=0).max() / np.linalg.norm(away, axis=1, keepdims=True)
    strewn = [(np.concatenate([away, s.points]), np.concatenate([away / lengths, s.normals])) for s in scans]
    plain, found = found, mb.match(*strewn, **FAST)
    assert np.array_equal(found.source_to_target[count:], plain.source_to_target + count)
    assert np.array_equal(found.confidence[count:], plain.confidence)
    assert (found.confidence[:count] == 0).all()
    assert (found.source_to_target >= count).all()
    assert np.isin(found.source_to_target[:count], found.source_to_target[count:]).all()
    assert caplog.text.count("far from all others; not matched") == 2


@pytest.mark.parametrize(
    ("given", "said"),
    [
        (np.zeros((5, 2)), r"\(5, 2\)"),
        (np.zeros((0, 3)), "no points"),
        (np.full((9, 3), np.nan), "NaN"),
        ((np.zeros((5, 3)), np.zeros((4, 3))), "5 points and 4 normals"),
        (None, "give a Scan"),
        (object(), "give a Scan"),
        ("nowhere.ply", "does not exist"),
    ],
)
def test_clouds_that_cannot_be_used_are_refused_in_one_line(given, said, scans):
    with pytest.raises(mb.InputError, match=said) as caught:
        mb.match(scans[0], given, **FAST)
    assert "\n" not in str(caught.value)


def test_a_match_needs_at_least_a_point(scans):
    with pytest.raises(mb.InputError, match="at least 1"):
        mb.match(*scans, points=0)


def test_files_of_the_first_version_still_load(tmp_path):
    arrays = {
        "source_to_target": np.array([1, 0]),
        "confidence": np.array([0.5, 1.0]),
        "landmarks": np.array([[0, 1]]),
        "source_points": np.zeros((2, 3)),
        "target_points": np.ones((2, 3)),
    }
    meta = {"cost": 0.5, "flip": "flipped", "method": "medial", "seed": 3, "device": "cpu"}
    save_record(tmp_path / "old.npz", "Correspondence", arrays, meta)
    found = mb.Matching.load(tmp_path / "old.npz")
    assert (found.mirror_check, found.seed, found.about["method"]) == ("overruled", 3, "medial")
    for name, array in arrays.items():
        assert np.array_equal(getattr(found, name), array)


# ---------------------------------------------------------------------------- errors


@pytest.mark.parametrize("radius", [1.0, 50.0])
def test_errors_on_a_sphere_are_arcs(radius):
    """Of a map onto the sphere turned by a right angle, whose area is 4 pi r^2; of no match, nan."""
    mesh = trimesh.creation.icosphere(subdivisions=4, radius=radius)
    cloud = mb.sample(mesh, 400)
    turned = cloud.points @ np.array([[0.0, -1, 0], [1, 0, 0], [0, 0, 1]]).T
    image = cKDTree(cloud.points).query(turned)[1]
    places = cloud.points / np.linalg.norm(cloud.points, axis=1, keepdims=True)
    arcs = np.arccos(np.clip(np.einsum("nd,nd->n", places[image], places), -1, 1))
    image[7] = -1
    found = mb.Matching(image, np.zeros((0, 2), np.int64), 0.0, np.ones(400), {})
    errors = mb.geodesic_error(found, cloud, cloud, as_shape(mesh, name=cloud.shape_name))
    assert np.isnan(errors[7])
    there = np.arange(400) != 7
    assert arcs.max() > 1.4
    assert errors[there] == pytest.approx(100 * arcs[there] / np.sqrt(4 * np.pi), rel=0.03, abs=0.3)


def test_errors_need_ground_truth(body, scans, found):
    a, b = scans
    blind = replace(a, face_ids=np.full(len(a), -1, np.int32))
    with pytest.raises(mb.InputError, match="source has no ground truth"):
        mb.geodesic_error(found, blind, b, body)
    with pytest.raises(mb.InputError, match="target is 'ndarray'"):
        mb.geodesic_error(found, a, b.points, body)
    with pytest.raises(mb.InputError, match="give the body that was scanned"):
        mb.geodesic_error(found, replace(a, face_ids=a.face_ids + 10**6), b, body)
    with pytest.raises(mb.InputError, match="does not fit"):
        mb.geodesic_error(found, a.subsample(100), b, body)
    with pytest.raises(mb.InputError, match="is no body"):
        mb.geodesic_error(found, a, b, "human")
    with pytest.raises(mb.InputError, match="no ground truth"):
        mb.diffusion_error(blind, body)


def test_diffusion_errors_grow_with_what_is_missing(body, scans):
    complete = mb.diffusion_error(mb.sample(body["rest"], 600), body, modes=30)
    assert complete == pytest.approx(0, abs=1e-9)  # the very same samples
    assert mb.diffusion_error(scans[1], body, modes=30) > complete


def test_maps_and_bodies_that_do_not_belong_together_are_refused(body, scans, found, tmp_path):
    (a, b), sphere = scans, trimesh.creation.icosphere(subdivisions=3)
    for pose in ("rest", "bent"):
        sphere.export(tmp_path / f"{pose}.ply")  # the same faces, another body
    other = mb.load(tmp_path)
    swapped = mb.match(b, a, **FAST)
    for said, call in (
        ("another source", lambda: mb.geodesic_error(found, b, a, body)),
        ("another target", lambda: mb.geodesic_error(found, a, a, body)),
        ("another source", lambda: mb.geodesic_error(swapped, a, b, body)),
        ("give the body that was scanned", lambda: mb.geodesic_error(found, a, b, other)),
        ("give the body that was scanned", lambda: mb.geodesic_error(found, a, b, other.reference)),
        ("give the body that was scanned", lambda: mb.diffusion_error(a, other, modes=30)),
    ):
        with pytest.raises(mb.InputError, match=said):
            call()
    mb.geodesic_error(found, a, b, body.reference)
    bent_club(0.1).export(tmp_path / "file.ply")  # a scan that does not know its subject
    mb.geodesic_error(found, a, replace(b, shape_name="file"), body)


# ---------------------------------------------------------------------------- as in the paper


def test_departures_reach_equation_18(body, scans):
    """Without its factor the error is in one over area, and as `evaluation.diffusion_error` gives it."""
    ours = mb.diffusion_error(scans[0], body, modes=30)
    written = mb.diffusion_error(scans[0], body, modes=30, departures={"eq18_area_factor": False})
    assert written == pytest.approx(ours / body.reference.area, rel=1e-12)


def test_departures_reach_the_matcher(scans):
    found = mb.match(*scans, **SIZE, departures="none")
    assert found.config == mb.MatchConfig.paper(mb.Departures.none())
    settings = mb.match(*scans, **SIZE, config="paper").config
    assert settings == mb.MatchConfig.paper(mb.Departures())
    assert mb.symmetry(scans[0], **SIZE, departures="none").config == found.config
    diffusion = mb.Diffusion.from_points(scans[0].points, scans[0].normals, modes=30, departures="none")
    assert mb.match(diffusion, scans[1], points=400).config == found.config  # the other cloud follows
    with pytest.raises(
        mb.InputError, match="Diffusion with other departures; build it with departures='all'"
    ):
        mb.match(diffusion, diffusion, departures="all")


# ---------------------------------------------------------------------------- plot


def test_anything_can_be_drawn(body, scans, found, tmp_path):
    a, b = scans
    diffusion = mb.Diffusion.from_points(a.points, a.normals, modes=20)
    heat = mb.Diffusion.from_points(a.points, a.normals, operator="heat", modes=20)
    pictures = (
        (1, (body["rest"],)),
        (2, (body,)),
        (1, (a,)),
        (1, (a.points,)),
        (1, ((a.points, a.normals),)),
        (3, (diffusion,)),
        (1, (heat,)),
        (3, (found,)),
        (3, (found, a, b)),
        (3, (found, a.points, b.points)),
    )
    for panels, things in pictures:
        assert len(drawn(mb.plot(*things, height=60))) == panels
    found.save(tmp_path / "map.npz")
    diffusion.save(tmp_path / "diffusion.npz")
    bent_club(0.0).export(tmp_path / "mesh.ply")
    for panels, name in ((3, "map.npz"), (3, "diffusion.npz"), (1, "mesh.ply")):
        assert len(drawn(mb.plot(tmp_path / name, height=60))) == panels


def test_pictures_show_in_a_notebook_and_are_saved(scans, tmp_path):
    figure = mb.plot(scans[0], height=60)
    assert figure._repr_png_()[:4] == b"\x89PNG"
    for suffix, begins in (("png", b"\x89PNG"), ("pdf", b"%PDF"), ("svg", b"<?xml")):
        figure.savefig(tmp_path / f"scan.{suffix}")
        assert (tmp_path / f"scan.{suffix}").read_bytes().startswith(begins)
    picture = np.array(Image.open(tmp_path / "scan.png").convert("RGB")).reshape(-1, 3)
    assert len(np.unique(picture, axis=0)) > 50  # shaded points, and not a blank page


def test_views_show_in_a_notebook_and_are_saved(scans, found, tmp_path):
    for things in ((found, *scans), (found,), (scans[0],), (scans[0].points,)):
        view = mb.plot(*things, interactive=True)
        assert view._repr_html_().startswith('<iframe srcdoc="&lt;!DOCTYPE html&gt;')
        assert len(view.scene.clouds[0].points) == 600
    view = mb.plot(found, *scans, interactive=True)
    assert np.array_equal(view.scene.maps[0].image, found.source_to_target)
    view.save(tmp_path / "map.html")
    assert (tmp_path / "map.html").read_text().startswith("<!DOCTYPE html>")
    with pytest.raises(mb.InputError, match="a Diffusion has no view"):
        mb.plot(mb.Diffusion.from_points(scans[0].points, modes=20), interactive=True)


def test_pictures_that_cannot_be_drawn_are_refused(scans, found):
    a, b = scans
    diffusion = mb.Diffusion.from_points(a.points, a.normals, modes=20)
    for said, call in (
        ("no mode 20", lambda: mb.plot(diffusion, mode=20)),
        ("no option 'mode'", lambda: mb.plot(a, mode=2)),
        ("up must be", lambda: mb.plot(a, up="w")),
        ("holds no points", lambda: mb.plot(replace(found, source_points=None))),
        ("600 source points", lambda: mb.plot(found, a.points[:50], b)),
        ("the target has 50", lambda: mb.plot(found, a, b.points[:50])),
        ("another source", lambda: mb.plot(found, b, a)),
        ("two clouds", lambda: mb.plot(found, a, b, b)),
        ("only a Matching", lambda: mb.plot(a, b)),
        ("give a Scan", lambda: mb.plot(3)),
    ):
        with pytest.raises(mb.InputError, match=said):
            call()


# ---------------------------------------------------------------------------- values of the wrong kind


@pytest.mark.parametrize("points", [100.5, "a", None, True, -1])
def test_points_are_a_count(scans, points):
    with pytest.raises(mb.InputError, match="points is"):
        mb.match(*scans, points=points)
    with pytest.raises(mb.InputError, match="points is"):
        mb.symmetry(scans[0], points=points)
    with pytest.raises(mb.InputError, match="points is"):
        scans[0].subsample(points)


@pytest.mark.parametrize(
    ("settings", "said"),
    [
        ({"modes": 2.5}, "modes must be a whole number"),
        ({"modes": "x"}, "modes must be a whole number"),
        ({"eta": "x"}, "eta must be a finite number or None"),
        ({"seed": -1}, "seed is -1"),
        ({"seed": 1.5}, "seed is 1.5"),
        ({"seed": "x"}, "seed is 'x'"),
        ({"sigma": 3}, "'sigma'"),
    ],
)
def test_settings_are_checked(scans, settings, said):
    for call in (lambda: mb.match(*scans, **settings), lambda: mb.symmetry(scans[0], **settings)):
        with pytest.raises(mb.InputError, match=said):
            call()


def test_numbers_of_numpy_are_numbers(scans, found, tmp_path):
    numbers = {"modes": np.int64(30), "points": np.int32(400), "seed": np.int64(0), "eta": np.float32(0.5)}
    numbers["config"] = CHEAP
    same = mb.match(*scans, **numbers)
    assert np.array_equal(same.source_to_target, found.source_to_target)
    same.save(tmp_path / "map.npz")
    mb.Diffusion.from_points(scans[0].points, modes=20, eta=np.float32(0.5)).save(tmp_path / "d.npz")


def test_a_diffusion_decides_the_settings_of_the_other_cloud(scans):
    a, b = scans
    made = mb.Diffusion.from_points(a.points, a.normals, modes=20, eta=None, sigma_t=0.6)
    other = mb.Diffusion.from_points(b.points, b.normals, modes=20, eta=None, sigma_t=0.6)
    expected = mb.match(made, other, config=CHEAP).source_to_target
    assert np.array_equal(mb.match(made, b, config=CHEAP).source_to_target, expected)
    with pytest.raises(mb.InputError, match="eta"):
        mb.match(made, mb.Diffusion.from_points(b.points, b.normals, modes=20))


def test_complex_numbers_are_refused(body, scans):
    points, shape = scans[0].points, body["rest"]
    for call in (
        lambda: mb.match(points + 1j, scans[1]),
        lambda: mb.match((points, scans[0].normals * 1j), scans[1]),
        lambda: mb.Diffusion.from_points(points * 1j),
        lambda: mb.plot(points * 1j),
        lambda: mb.sample((shape.vertices * 1j, shape.faces), 10),
    ):
        with pytest.raises(mb.InputError, match="complex numbers"):
            call()


@pytest.mark.parametrize("operator", ["heat", "robust"])
def test_symmetries_of_other_operators(scans, operator):
    """The club is symmetric in z."""
    points = scans[0].points
    found = mb.symmetry(scans[0], operator=operator, **FAST)
    gap = np.linalg.norm(points[found.source_to_target] - points * [1, 1, -1], axis=1)
    assert gap.mean() < 0.3 * 2 * np.abs(points[:, 2]).mean()  # of the identity 2 |z|


def test_errors_are_of_maps(body, scans, found):
    from dataclasses import replace

    ids = found.source_to_target
    for given in (None, ids, ids * 1.0, replace(found, source_to_target=ids * 1.0)):
        with pytest.raises(mb.InputError, match="is no map; give what match"):
            mb.geodesic_error(given, *scans, body)


def test_sizes_and_modes_of_pictures_are_counts(scans):
    diffusion = mb.Diffusion.from_points(scans[0].points, modes=20)
    for height in (0, -5, "x", 10.5, None):
        with pytest.raises(mb.InputError, match="height is"):
            mb.plot(scans[0], height=height)
    for mode in ("x", 1.5, -1, None):
        with pytest.raises(mb.InputError, match="mode is"):
            mb.plot(diffusion, mode=mode)
