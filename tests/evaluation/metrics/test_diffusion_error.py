import numpy as np
import pytest

from datasets_gen import InputError
from evaluation.metrics.diffusion_error import diffusion_error, interpolation, kernel_error, kernel_of_pairs
from medial import Departures, Diffusion
from scanner_sim import sample
from tests.evaluation.meshes import blob


def build(shape, n, seed=0, operator="heat"):
    cloud = sample(shape, n, seed)
    return cloud, Diffusion.from_points(cloud.points, cloud.normals, operator=operator, modes=40)


@pytest.fixture(scope="module")
def rest():
    shape = blob()
    return shape, *build(shape, 600)


def error(rest, cloud, diffusion, **options):
    shape, _, reference = rest
    from datasets_gen.meshes.geometry import face_normals

    where = shape.at(cloud.face_ids, cloud.barycentrics)
    normals = face_normals(shape.vertices, shape.faces)[cloud.face_ids]
    return diffusion_error(reference, diffusion, where, normals, shape.area, pairs=2000, **options)


@pytest.mark.parametrize("operator", ["heat", "medial"])
def test_the_reference_against_itself_is_exactly_zero(operator):
    shape = blob()
    cloud, diffusion = build(shape, 600, operator=operator)
    found = error((shape, cloud, diffusion), cloud, diffusion)
    assert found.eq18 == 0
    assert found.eq18_trace == 0
    assert found.eq18_relative == 0


def test_error_grows_as_surface_goes_missing(rest):
    shape, _, _ = rest
    whole = sample(shape, 2000, 1)
    found = []
    for kept in (1.0, 0.7, 0.4):
        cloud = whole.select(whole.points[:, 0] <= np.quantile(whole.points[:, 0], kept)).subsample(600)
        found.append(error(rest, cloud, Diffusion.from_points(cloud.points, cloud.normals, "heat", 40)).eq18)
    assert found == sorted(found)
    assert found[2] > 2 * found[0]


def test_equation_18_against_a_plain_loop(rest):
    shape, _, reference = rest
    cloud, diffusion = build(shape, 500, 3)
    found = error(rest, cloud, diffusion, seed=5)
    from datasets_gen.meshes.geometry import face_normals

    carry = interpolation(
        reference.points,
        reference.normals,
        shape.at(cloud.face_ids, cloud.barycentrics),
        face_normals(shape.vertices, shape.faces)[cloud.face_ids],
    ).toarray()
    x, y = np.random.default_rng(5).integers(len(cloud), size=(2, 2000))
    total = 0.0
    for t in found.times:
        m = diffusion.kernel(t, np.arange(len(cloud)), np.arange(len(cloud)))[x, y]
        every = np.arange(len(reference))
        f = (carry @ reference.kernel(t, every, every) @ carry.T)[x, y]
        total += np.sqrt((shape.area**2 * (m - f) ** 2).sum())
    assert found.eq18 == pytest.approx(total / (len(found.times) * 2000), rel=1e-9)
    assert found.eq18 == pytest.approx(found.per_time.mean())


def test_does_not_depend_on_the_unit_of_length(rest):
    from dataclasses import replace

    shape, _, _ = rest
    cloud, diffusion = build(shape, 500, 3)
    small = error(rest, cloud, diffusion).eq18
    scaled = replace(shape, vertices=10 * shape.vertices)
    ten = error((scaled, *build(scaled, 600)), *build(scaled, 500, 3)).eq18
    assert ten == pytest.approx(small, rel=0.02)


def test_interpolation_is_exact_at_samples_and_does_not_leak_through_a_sheet():
    grid = np.stack(np.meshgrid(np.linspace(0, 1, 12), np.linspace(0, 1, 12)), -1).reshape(-1, 2)
    top = np.column_stack([grid, np.full(len(grid), 0.01)])
    bottom = np.column_stack([grid, np.zeros(len(grid))])
    samples = np.vstack([top, bottom])
    normals = np.vstack([np.tile([0, 0, 1.0], (len(grid), 1)), np.tile([0, 0, -1.0], (len(grid), 1))])
    values = np.repeat([1.0, 0.0], len(grid))
    at = np.random.default_rng(0).uniform(0, 1, (50, 2))
    on_top = interpolation(
        samples, normals, np.column_stack([at, np.full(50, 0.01)]), np.tile([0, 0, 1.0], (50, 1))
    )
    assert np.allclose(on_top.sum(axis=1), 1)
    assert np.allclose(on_top @ values, 1)
    assert (interpolation(samples, normals, samples, normals) @ values == values).all()
    smooth = samples[:, 0] * (normals[:, 2] > 0)
    assert np.abs(on_top @ smooth - at[:, 0]).max() < 0.05


def test_without_the_area_factor_the_error_keeps_its_unit(rest):
    """As written: the dimensionless error divided by the area of the reference."""
    shape, _, _ = rest
    cloud, diffusion = build(shape, 500, 3)
    ours, written = (
        error(rest, cloud, diffusion, departures=each) for each in (Departures(), Departures.none())
    )
    assert written.per_time == pytest.approx(ours.per_time / shape.area, rel=1e-12)
    assert written.eq18_relative == pytest.approx(ours.eq18_relative)


def test_kernel_error_falls_with_the_root_of_the_number_of_pairs():
    here = np.random.default_rng(0).uniform(size=(50, 3))
    assert kernel_error(np.tile(here, (4, 1)), np.zeros((200, 3))) == pytest.approx(
        kernel_error(here, np.zeros((50, 3))) / 2
    )


def test_kernel_of_pairs_is_the_kernel(rest):
    _, _, reference = rest
    x, y = np.arange(5), np.arange(5, 10)
    pairs = kernel_of_pairs(reference.eigenfunctions, reference.eigenvalues, x, y, np.array([0.1, 1.0]))
    assert np.allclose(pairs[:, 1], np.diag(reference.kernel(1.0, x, y)))


def test_operators_must_agree(rest):
    shape, _, _ = rest
    with pytest.raises(InputError, match="compare"):
        error(rest, *build(shape, 300, operator="medial"))


@pytest.mark.parametrize("operator", ["heat", "medial"])
@pytest.mark.parametrize("scale", [1000.0, 0.01])
def test_a_cloud_in_other_units_has_the_same_error(operator, scale):
    """Eq. 18 compares diffusions of one body: 1000 times its size is millimetres for metres."""
    shape = blob()
    rest = (shape, *build(shape, 500, operator=operator))
    cloud, diffusion = build(shape, 400, 3, operator)
    large = Diffusion.from_points(scale * cloud.points, cloud.normals, operator, modes=40)
    right, found = error(rest, cloud, diffusion), error(rest, cloud, large, scale=scale)
    for name in ("eq18", "eq18_trace", "eq18_relative"):
        assert getattr(found, name) == pytest.approx(getattr(right, name), rel=1e-4)


def test_settings_must_agree(rest):
    shape, cloud, _ = rest
    reference, other = (
        Diffusion.from_points(cloud.points, cloud.normals, modes=20, eta=eta) for eta in (0.5, None)
    )
    with pytest.raises(InputError, match=r"cannot compare diffusions built with eta=0.5 and eta=None"):
        error((shape, cloud, reference), cloud, other)
    with pytest.raises(InputError, match="seed is -1"):
        error((shape, cloud, reference), cloud, reference, seed=-1)
