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


def by_hand(points, normals, areas, values, functions, operator="heat"):
    """A diffusion of arbitrary modes."""
    n = len(points)
    return Diffusion(points, normals, areas, values, functions, points, np.zeros(n), operator)


def weights_by_loops(samples, sample_normals, point, normal):
    """Inverse squared distances over the four nearest of the 16 nearest samples that face the same way."""
    order = sorted(range(len(samples)), key=lambda i: sum((samples[i] - point) ** 2))[:16]
    facing = [i for i in order if sample_normals[i] @ normal > 0] or order
    weights = np.zeros(len(samples))
    for i in facing[:4]:
        square = sum((samples[i] - point) ** 2)
        if square == 0:
            return np.eye(len(samples))[i]
        weights[i] = 1 / square
    return weights / weights.sum()


@pytest.mark.parametrize("count", [40, 10, 3])
def test_interpolation_by_loops(count):
    """Between few samples and many, beside others that face away, and where all of the nearest do."""
    rng = np.random.default_rng(1)
    samples, points = rng.uniform(size=(count, 3)), rng.uniform(size=(25, 3))
    points[:2] = samples[:2]
    sample_normals, normals = np.tile([0, 0, 1.0], (count, 1)), rng.normal(size=(25, 3))
    sample_normals[rng.uniform(size=count) < 0.5] *= -1
    normals[0], normals[1] = sample_normals[0], -sample_normals[1]
    near = np.linalg.norm(samples - points[2], axis=1).argsort()[:16]
    sample_normals[near], normals[2] = [0, 0, 1.0], [0, 0, -1.0]
    found = interpolation(samples, sample_normals, points, normals)
    written = [weights_by_loops(samples, sample_normals, *each) for each in zip(points, normals, strict=True)]
    assert found.toarray() == pytest.approx(np.array(written), abs=1e-12)


def test_by_hand_a_sample_at_right_angles_does_not_face_the_same_way():
    samples = np.array([[0.0, 0, 0], [1, 0, 0], [3, 0, 0]])
    sample_normals = np.array([[0, 0, 1.0], [0, 1, 0], [0, 0, 1]])
    found = interpolation(samples, sample_normals, np.array([[1.0, 0, 0]]), np.array([[0, 0, 1.0]]))
    assert found.toarray() == pytest.approx(np.array([[0.8, 0, 0.2]]))


def test_interpolation_by_loops_where_samples_coincide_or_are_alone():
    """Of two samples at the point itself each counts half; a sample alone is all there is."""
    samples = np.array([[0.0, 0, 0], [0, 0, 0], [1, 0, 0]])
    up = np.array([[0, 0, 1.0]])
    found = interpolation(samples, np.repeat(up, 3, axis=0), samples[:1], up).toarray()
    assert found == pytest.approx(np.array([[0.5, 0.5, 0]]))
    assert interpolation(samples[:1], up, np.array([[2.0, 1, 0]]), up).toarray().tolist() == [[1.0]]
    assert interpolation(samples[:1], up, samples[:1], up).toarray().tolist() == [[1.0]]


def test_kernel_error_by_loops():
    """Eq. 18: the norm over the pairs divided by their number, at each time."""
    here, there = np.random.default_rng(0).uniform(size=(2, 7, 3))
    written = [np.sqrt(sum((here[c, t] - there[c, t]) ** 2 for c in range(7))) / 7 for t in range(3)]
    assert kernel_error(here, there) == pytest.approx(written)


def test_kernel_of_pairs_by_loops():
    rng = np.random.default_rng(0)
    functions, values, times = rng.normal(size=(6, 3)), np.array([0.0, 1, 2.5]), np.array([0.1, 0.7])
    x, y = np.array([0, 3, 5, 5]), np.array([1, 3, 2, 0])
    written = [
        [sum(functions[a, k] * functions[b, k] * np.exp(-values[k] * t) for k in range(3)) for t in times]
        for a, b in zip(x, y, strict=True)
    ]
    assert kernel_of_pairs(functions, values, x, y, times) == pytest.approx(np.array(written))


@pytest.mark.parametrize("scale", [1.0, 1000.0])
@pytest.mark.parametrize("departures", [None, Departures.none()])
def test_equation_18_by_loops(scale, departures):
    """All three errors of two arbitrary diffusions, one pair and one time after the other.

    Eigenvalues of a Laplacian are in one over area: lengths 1000 times as large make them a million times
    smaller.
    """
    rng = np.random.default_rng(2)
    up = np.tile([0, 0, 1.0], (8, 1))
    first, other = (np.cumsum(np.append(0, rng.uniform(0.5, 2, 3))) for _ in range(2))
    place = rng.uniform(size=(8, 3))
    functions, modes = rng.normal(size=(8, 4)), rng.normal(size=(5, 4))
    reference = by_hand(place, up, np.full(8, 0.1), first, functions)
    canonical = np.vstack([place[:2], rng.uniform(size=(3, 3))])
    cloud = by_hand(scale * canonical, up[:5], np.full(5, 0.2) * scale**2, other / scale**2, modes / scale)
    found = diffusion_error(
        reference,
        cloud,
        canonical,
        up[:5],
        3.7,
        pairs=30,
        times=6,
        seed=4,
        scale=scale,
        departures=departures,
    )
    area = 3.7 if departures is None else 1.0
    carried = np.array([weights_by_loops(place, up, p, up[0]) for p in canonical]) @ functions
    x, y = np.random.default_rng(4).integers(5, size=(2, 30))
    times = np.geomspace(4 * np.log(10) / first[-1], 4 * np.log(10) / first[1], 6)
    terms, traced, relative = [], [], []
    for t in times:
        m = [sum(modes[a] * modes[b] * np.exp(-other * t)) for a, b in zip(x, y, strict=True)]
        f = [sum(carried[a] * carried[b] * np.exp(-first * t)) for a, b in zip(x, y, strict=True)]
        m, f = area * np.array(m), area * np.array(f)
        terms.append(np.sqrt(sum((m - f) ** 2)) / 30)
        traced.append(np.sqrt(sum((m / sum(np.exp(-other * t)) - f / sum(np.exp(-first * t))) ** 2)) / 30)
        relative.append(np.sqrt(sum((m - f) ** 2)) / np.sqrt(sum(f**2)))
    assert found.times == pytest.approx(times)
    assert found.per_time == pytest.approx(terms)
    assert found.eq18 == pytest.approx(np.mean(terms))
    assert found.eq18_trace == pytest.approx(np.mean(traced))
    assert found.eq18_relative == pytest.approx(np.mean(relative))


def test_arrays_by_hand_that_do_not_belong_to_the_cloud_are_refused():
    up = np.tile([0, 0, 1.0], (4, 1))
    cloud = by_hand(np.eye(4, 3), up, np.ones(4), np.array([0.0, 1]), np.ones((4, 2)))
    for places, normals in ((up[:3], up), (up, up[:3]), (up[:, :2], up)):
        with pytest.raises(InputError, match="do not belong to a cloud of 4"):
            diffusion_error(cloud, cloud, places, normals, 1.0)
