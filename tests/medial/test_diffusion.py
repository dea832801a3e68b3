import logging

import numpy as np
import pytest

from datasets_gen.records import InputError, save_record
from medial import Diffusion
from medial.diffusion import GONE, decay
from medial.operator import OPERATORS, Operator
from medial.spectrum.equations import diffused, diffusion_kernel, heat_rate
from tests.medial import clouds

ARRAYS = ("points", "normals", "areas", "eigenvalues", "eigenfunctions", "centers", "radii")
SPHERE = np.concatenate([np.full(2 * degree + 1, degree * (degree + 1.0)) for degree in range(4)])


@pytest.fixture(scope="module")
def figure():
    return clouds.body(800)


@pytest.fixture(scope="module", params=OPERATORS)
def diffusion(request, figure):
    return Diffusion.from_points(*figure, request.param, modes=40)


@pytest.mark.parametrize(("operator", "error"), [("heat", 0.06), ("robust", 0.03)])
def test_surface_operators_have_the_spectrum_of_the_sphere(operator, error):
    """l(l + 1); a Gaussian of bandwidth h gives (1 - exp(-lambda h / 4)) 4 / h instead, 5 % less at l = 3."""
    points, normals = clouds.sphere(1500, radius=2.0)
    found = Diffusion.from_points(points, normals, operator, modes=16)
    assert 4 * found.eigenvalues == pytest.approx(SPHERE, rel=error, abs=1e-6)
    assert found.areas.sum() == pytest.approx(16 * np.pi, rel=0.01)
    assert (found.centers == points).all()
    assert not found.radii.any()


def test_medial_operator_sees_a_sphere_as_one_place():
    """All points share the centre, so Eq. 8 is the deviation from the mean: one eigenvalue, the area."""
    points, normals = clouds.sphere(500)
    found = Diffusion.from_points(points, normals, modes=20, eta=None)
    assert found.eigenvalues[1:] == pytest.approx(np.full(19, 4 * np.pi), rel=0.02)
    assert np.abs(found.centers).max() < 1e-6
    assert found.radii == pytest.approx(np.ones(500))
    assert found.areas.sum() == pytest.approx(4 * np.pi, rel=0.02)


def test_low_modes_of_a_cylinder_run_along_its_axis():
    points, normals = clouds.cylinder(1500, length=2.4)
    found = Diffusion.from_points(points, normals, modes=6)
    for mode in (1, 2):
        values = found.eigenfunctions[:, mode]
        z = np.round(points[:, 2] / 0.1) * 0.1
        mean = {level: values[z == level].mean() for level in np.unique(z)}
        along = np.array([mean[level] for level in z])
        assert np.var(values - along) < 0.1 * np.var(values)


def test_modes_are_orthonormal_and_start_with_the_constant(diffusion):
    psi = diffusion.eigenfunctions
    assert psi.T @ (diffusion.areas[:, None] * psi) == pytest.approx(np.eye(40), abs=1e-8)
    assert psi[:, 0] == pytest.approx(np.full(800, diffusion.areas.sum() ** -0.5), rel=1e-4)
    assert diffusion.eigenvalues[0] == pytest.approx(0, abs=1e-8 * diffusion.eigenvalues[-1])
    assert (np.diff(diffusion.eigenvalues) >= 0).all()
    assert diffusion.parameters["residual"] < 1e-6


def test_kernel_is_a_semigroup_that_keeps_heat(diffusion):
    """m_(s+t) = m_s A m_t, and all of the modes' heat stays (Eqs. 11-13)."""
    every = np.arange(800)
    t = 2 / diffusion.eigenvalues[5]
    once, twice = diffusion.kernel(t, every, every), diffusion.kernel(2 * t, every, every)
    assert np.abs((once * diffusion.areas) @ once - twice).max() < 1e-9 * np.abs(twice).max()
    assert once @ diffusion.areas == pytest.approx(np.ones(800), rel=1e-5)
    assert np.abs(once - once.T).max() < 1e-12 * np.abs(once).max()


def test_decay_is_exponential_until_a_mode_is_gone():
    eigenvalues, times = np.linspace(0, 1000, 400), np.geomspace(1e-3, 1, 9)
    exact = np.exp(-np.outer(eigenvalues, times))
    found = decay(eigenvalues, times)
    assert (found[exact >= GONE] == exact[exact >= GONE]).all()
    assert (found[exact < GONE] == 0).all()
    assert ((exact > 0) & (exact < np.finfo(np.float32).tiny)).any()
    assert (decay(eigenvalues, times[3]) == found[:, 3]).all()


def test_kernel_equals_equations_11_to_13(diffusion):
    """Heat diffused by m_t solves the heat equation of the kept modes."""
    every, t = np.arange(800), 2 / diffusion.eigenvalues[5]
    kernel = diffusion_kernel(diffusion.eigenvalues, diffusion.eigenfunctions, t)
    assert diffusion.kernel(t, every, every) == pytest.approx(kernel, abs=1e-12 * np.abs(kernel).max())
    psi, step = diffusion.eigenfunctions, 1e-4 * t
    laplacian = (psi * diffusion.eigenvalues) @ (psi.T * diffusion.areas)
    start = np.random.default_rng(0).standard_normal(800)
    before, now, after = (
        diffused(diffusion_kernel(diffusion.eigenvalues, psi, each), start, diffusion.areas)
        for each in (t - step, t, t + step)
    )
    rate = heat_rate(laplacian, now)
    assert (after - before) / (2 * step) == pytest.approx(rate, abs=1e-6 * np.abs(rate).max())


def test_signature_and_heat_trace(diffusion):
    """The heat that stays, sum exp(-lambda t) psi(x)^2, and its integral, sum exp(-lambda t) [SOG09]."""
    times = np.array([0.5, 2.0]) / diffusion.eigenvalues[3]
    decayed = np.exp(-np.outer(diffusion.eigenvalues, times))
    assert diffusion.signature(times) == pytest.approx(diffusion.eigenfunctions**2 @ decayed)
    assert diffusion.heat_trace(times) == pytest.approx(decayed.sum(axis=0))
    assert diffusion.areas @ diffusion.signature(times) == pytest.approx(decayed.sum(axis=0))


def test_order_of_points_does_not_matter(figure, diffusion):
    order = np.random.default_rng(0).permutation(800)
    again = Diffusion.from_points(figure[0][order], figure[1][order], diffusion.operator, modes=40)
    assert (again.points == diffusion.points[order]).all()
    if diffusion.operator == "robust":  # its triangulation breaks ties by order
        assert again.eigenvalues == pytest.approx(diffusion.eigenvalues, rel=1e-6, abs=1e-9)
    else:
        assert (again.eigenvalues == diffusion.eigenvalues).all()
        assert (again.eigenfunctions == diffusion.eigenfunctions[order]).all()
        assert (again.areas == diffusion.areas[order]).all()


def test_rotation_does_not_matter(figure, diffusion):
    turn = clouds.rotation(3)
    again = Diffusion.from_points(figure[0] @ turn.T, figure[1] @ turn.T, diffusion.operator, modes=40)
    error = (
        0.02 if diffusion.operator == "robust" else 1e-4
    )  # triangulations of nearly cocircular points differ
    assert again.eigenvalues == pytest.approx(diffusion.eigenvalues, rel=error, abs=1e-7)
    assert again.areas.sum() == pytest.approx(diffusion.areas.sum(), rel=error)


def test_scale_changes_the_unit_only(figure, diffusion):
    again = Diffusion.from_points(10 * figure[0], figure[1], diffusion.operator, modes=40)
    factor = 1 if diffusion.operator == "medial" else 100  # the normalised weights of Eq. 15 have no unit
    assert factor * again.eigenvalues == pytest.approx(diffusion.eigenvalues, rel=1e-3, abs=1e-6)
    assert again.areas == pytest.approx(100 * diffusion.areas, rel=1e-6)


def test_save_and_load(tmp_path, diffusion):
    diffusion.save(tmp_path / "d.npz")
    read = Diffusion.load(tmp_path / "d.npz")
    assert (read.operator, read.parameters) == (diffusion.operator, diffusion.parameters)
    for name in ARRAYS:
        assert (getattr(read, name) == getattr(diffusion, name)).all()


def test_older_files_with_a_companion_are_read(tmp_path, diffusion):
    """Files once held a second, surface basis of the same points."""
    own = {name: getattr(diffusion, name) for name in ARRAYS}
    meta = {"operator": diffusion.operator, "parameters": {}}
    companion = {f"surface_{name}": array for name, array in own.items()}
    save_record(tmp_path / "d.npz", "Diffusion", own | companion, meta | {"surface": meta})
    assert (Diffusion.load(tmp_path / "d.npz").eigenfunctions == diffusion.eigenfunctions).all()


def test_repr_is_one_line(diffusion):
    area = diffusion.areas.sum()
    assert repr(diffusion) == f"Diffusion({diffusion.operator!r}, n=800, k=40, area={area:.6g})"


def test_points_alone_are_enough(figure):
    found = Diffusion.from_points(figure[0])
    assert (found.eigenvalues.shape, found.operator) == ((300,), "medial")


def test_duplicated_points_share_their_area(figure):
    points, normals = figure[0][:500], figure[1][:500]
    once = Diffusion.from_points(points, normals, modes=20)
    twice = Diffusion.from_points(np.repeat(points, 2, axis=0), np.repeat(normals, 2, axis=0), modes=20)
    assert twice.eigenvalues == pytest.approx(once.eigenvalues, abs=1e-12)
    assert twice.areas[::2] == pytest.approx(once.areas / 2)
    assert (twice.eigenfunctions[::2] == twice.eigenfunctions[1::2]).all()
    psi = twice.eigenfunctions
    assert psi.T @ (twice.areas[:, None] * psi) == pytest.approx(np.eye(20), abs=1e-8)


@pytest.mark.parametrize("operator", ["medial", "heat"])
def test_disconnected_parts_have_a_zero_each(operator):
    points, normals = clouds.body(500)
    both = np.concatenate([points, points + np.array([50.0, 0, 0])])
    found = Diffusion.from_points(both, np.concatenate([normals, normals]), operator, modes=10)
    assert np.abs(found.eigenvalues[:2]).max() < 1e-6 * found.eigenvalues[2]
    assert np.isfinite(found.eigenfunctions).all()


@pytest.mark.parametrize("operator", OPERATORS)
def test_stray_points_do_no_harm(figure, operator):
    strays = np.array([[3.0, 0, 0], [0, 9.0, 0], [0, 9.01, 0]])
    points, normals = np.concatenate([figure[0], strays]), np.concatenate([figure[1], np.eye(3)])
    found = Diffusion.from_points(points, normals, operator, modes=20)
    assert np.isfinite(found.eigenfunctions).all()
    assert (found.areas[:-3] > 0).all()
    assert (found.areas[-3:] == 0).all()
    alone = Diffusion.from_points(*figure, operator, modes=20)
    assert np.array_equal(found.eigenvalues, alone.eigenvalues)
    assert np.array_equal(found.eigenfunctions[:-3], alone.eigenfunctions)


def test_a_small_cloud_takes_the_modes_it_has(caplog):
    found = Diffusion.from_points(*clouds.sphere(40), modes=300)
    assert len(found.eigenvalues) == 39
    assert "40 places carry 39 modes, not 300" in caplog.text


def flat(dimensions):
    """Random points of the unit square or of its side, and their normals."""
    points = np.zeros((300, 3))
    points[:, :dimensions] = np.random.default_rng(0).uniform(size=(300, dimensions))
    return points, np.tile([0.0, 0, 1], (300, 1))


def explained(values, functions):
    """Shares of the variances of values (n, k) that constants and functions (n, f) explain."""
    basis = np.column_stack([np.ones(len(values)), functions])
    rest = values - basis @ np.linalg.lstsq(basis, values)[0]
    return 1 - rest.var(axis=0) / values.var(axis=0)


@pytest.mark.parametrize("operator", OPERATORS)
def test_first_modes_of_a_flat_square_are_cosines(operator, caplog):
    """Of a square with free edges cos(pi x) and cos(pi y), eigenvalues pi^2 (0, 1, 1, 2, 4, 4, 5, 5, 8)."""
    points, normals = flat(2)
    found = Diffusion.from_points(points, normals, operator, modes=9)
    assert explained(found.eigenfunctions[:, 1:3], np.cos(np.pi * points[:, :2])).min() > 0.99
    assert found.areas.sum() == pytest.approx(1, rel=0.08)
    if operator == "robust":  # the others take their points for samples of a surface without an edge
        assert found.eigenvalues / np.pi**2 == pytest.approx([0, 1, 1, 2, 4, 4, 5, 5, 8], rel=0.12, abs=1e-9)
    if operator == "medial":
        assert "no two points share a medial ball" in caplog.text


@pytest.mark.parametrize("operator", ["medial", "heat"])
def test_the_first_mode_of_a_line_is_a_cosine(operator):
    points, normals = flat(1)
    found = Diffusion.from_points(points, normals, operator, modes=10)
    assert explained(found.eigenfunctions[:, 1:2], np.cos(np.pi * points[:, :1]))[0] > 0.94


def test_a_line_has_no_tufted_laplacian():
    with pytest.raises(InputError, match="no tufted Laplacian"):
        Diffusion.from_points(*flat(1), "robust", modes=10)


def test_inward_normals_are_flipped(figure, caplog):
    outward = Diffusion.from_points(*figure, modes=10)
    inward = Diffusion.from_points(figure[0], -figure[1], modes=10)
    assert "point inward" in caplog.text
    assert (inward.normals == outward.normals).all()
    assert inward.eigenvalues == pytest.approx(outward.eigenvalues)


def test_inconsistent_normals_are_told(figure, caplog):
    signs = np.random.default_rng(0).choice([-1.0, 1.0], size=(800, 1))
    Diffusion.from_points(figure[0], signs * figure[1], modes=10)
    assert "of 800 normals point inward: flipped" in caplog.text


def test_good_normals_are_left_alone(figure, caplog):
    with caplog.at_level(logging.WARNING):
        found = Diffusion.from_points(*figure, modes=10)
    assert caplog.text == ""
    assert found.normals == pytest.approx(figure[1])


def test_missing_normals_are_estimated(figure, caplog):
    found = Diffusion.from_points(figure[0], None, modes=10)
    assert "estimated" in caplog.text
    agreement = np.einsum("ij,ij->i", found.normals, figure[1])
    assert (agreement > 0.8).mean() > 0.97


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"operator": "cotan"}, "unknown operator 'cotan'; choose one of medial, heat, robust"),
        ({"modes": 0}, "modes is 0"),
        ({"eta": 1.5}, "eta is 1.5"),
        ({"sigma_e": -1.0}, "sigma_e"),
        ({"reference_points": 0}, "reference_points is 0"),
        ({"tolerance": 0}, "tolerance is 0"),
        ({"departures": "some"}, "departures is 'some'; give 'all', 'none'"),
        ({"departures": {"radius": False}}, "unknown departure 'radius'; did you mean 'radius_cap'"),
        ({"departures": {"radius_cap": 1}}, "departure radius_cap must be true or false, got 1"),
    ],
)
def test_bad_settings(figure, settings, message):
    with pytest.raises(InputError, match=message):
        Diffusion.from_points(*figure, **settings)


def test_unknown_settings_are_rejected(figure):
    with pytest.raises((TypeError, InputError), match="sigma"):
        Diffusion.from_points(*figure, sigma=3)
    with pytest.raises(TypeError):
        Operator("medial")


@pytest.mark.parametrize("operator", OPERATORS)
def test_not_finite(figure, operator):
    points = figure[0].copy()
    points[17, 2] = np.nan
    with pytest.raises(InputError, match="number 17"):
        Diffusion.from_points(points, figure[1], operator, modes=10)


def test_all_points_at_one_place():
    with pytest.raises(InputError, match="all 50 points lie at one place"):
        Diffusion.from_points(np.ones((50, 3)), np.tile([0, 0, 1.0], (50, 1)), modes=1)
