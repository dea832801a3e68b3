"""Each departure from the paper, switched off, gives the equation as written (`medial.paper`)."""

import pickle
from dataclasses import asdict, replace

import numpy as np
import pytest
from scipy.linalg import eigh

from datasets_gen.records import InputError
from medial import (
    Departures,
    Diffusion,
    MatchConfig,
    density_weights,
    intrinsic_symmetry,
    match,
    surface_areas,
)
from medial.areas.equations import average_distance, dual_area, medial_neighbourhood
from medial.laplacian.equations import combined_weights, gaussian, point_cloud_laplacian
from medial.laplacian.weights import gaussian_weights
from medial.matching.prepared import prepare_pair
from medial.operator import SIZE_RULES, Operator, build_operator, medial_weights
from medial.paper import medial_diffusion
from medial.similarity.candidate_ball import smallest_width
from medial.similarity.equations import similarity_matrix
from medial.validation import check_cloud
from tests.medial import clouds

POINTS = 240
NONE = Departures.none()


@pytest.fixture(scope="module")
def figure():
    return clouds.body(POINTS, holes=3)


@pytest.fixture(scope="module")
def phi(figure):
    """Eqs. 4-7 as written."""
    return similarity_matrix(*figure)


def only(*names):
    """The paper but for some departures."""
    return replace(NONE, **dict.fromkeys(names, True))


def weights(figure, departures, eta=None, **settings):
    """Dense weights, and the rest of `medial_weights`."""
    cloud = check_cloud(*figure)
    made, *rest = medial_weights(
        cloud, surface_areas(*figure), Operator(departures=departures, eta=eta, **settings)
    )
    return made.toarray(), *rest


def close(found, written):
    assert found == pytest.approx(written, rel=1e-9, abs=1e-12 * np.abs(written).max())


def test_none_is_the_paper(figure):
    written = medial_diffusion(*figure)
    found = Diffusion.from_points(*figure, modes=100, departures="none")
    assert found.areas == pytest.approx(written.areas, rel=1e-9)
    assert found.centers == pytest.approx(written.centers, rel=1e-9, abs=1e-9)
    assert found.radii == pytest.approx(written.radii, rel=1e-9)
    assert found.eigenvalues[1:] == pytest.approx(written.eigenvalues[1:100], rel=1e-6)
    every = np.arange(POINTS)
    for t in 1 / written.eigenvalues[[3, 20]]:
        m = replace(written, eigenvalues=written.eigenvalues[:100],
                    eigenfunctions=written.eigenfunctions[:, :100]).kernel(t, every, every)  # fmt: skip
        assert np.abs(found.kernel(t, every, every) - m).max() < 1e-5 * np.abs(m).max()


def test_none_without_gaussian_weights_is_equation_8(figure, phi):
    cloud = check_cloud(*figure)
    config = Operator(departures="none", eta=None)
    stiffness, areas, _, _ = build_operator(cloud, config)
    f = np.random.default_rng(0).standard_normal(POINTS)
    close(stiffness @ f / areas, point_cloud_laplacian(f, phi, areas))


def test_similarity_as_written(figure, phi):
    close(weights(figure, NONE)[0], phi)


def test_density_weights_alone(figure):
    mass = density_weights(surface_areas(*figure), 5000)
    found = weights(figure, only("density_weights"), reference_points=5000)[0]
    close(found, similarity_matrix(*figure, weights=mass))


def test_radius_cap_alone(figure):
    """No cut-off, but a cap: of the fast form, in single precision."""
    written = similarity_matrix(*figure, r_cap=smallest_width(figure[0]))
    found = weights(figure, only("radius_cap"))[0]
    assert found == pytest.approx(written, abs=5e-6)
    assert ((found > 0) == (written > 1e-300)).all()


def test_truncation_alone(figure):
    written = similarity_matrix(*figure, cutoff=1e-4)
    close(weights(figure, only("truncation"), cutoff=1e-4)[0], written)


@pytest.mark.parametrize("joined", [False, True])
@pytest.mark.parametrize("calibrated", [False, True])
def test_areas(figure, joined, calibrated):
    names = ["nearest_join"] * joined + ["area_calibration"] * calibrated
    _, areas, centers, radii = weights(figure, only(*names))
    points, surface = figure[0], surface_areas(*figure)
    epsilon, written = 1.5 * average_distance(points), []
    for i in range(POINTS):
        near = np.linalg.norm(points - points[i], axis=1).argsort()[1:13] if joined else []
        members = np.union1d(medial_neighbourhood(i, centers, epsilon), near).astype(int)
        written.append(dual_area(i, members, points, centers[i], radii[i]))
    written = np.where(np.array(written) > 0, written, surface)
    close(areas, written / np.median(written / surface) if calibrated else written)


def test_gaussian_part_as_written(figure, phi):
    sigma, areas, _, _ = weights(figure, NONE, eta=0.3)
    alpha = gaussian(figure[0], 3 * surface_areas(*figure).mean())
    written = combined_weights(phi, alpha, areas, 0.3)
    np.fill_diagonal(written, 0)
    close(sigma, written)


def test_diffusion_rates_alone(figure, phi):
    """With one bandwidth h, all entries take the same factor h_ref / h."""
    sigma, areas, _, _ = weights(figure, only("diffusion_rates"), eta=0.3, reference_points=1000)
    cells = surface_areas(*figure)
    alpha = gaussian(figure[0], 3 * cells.mean())
    rate = (3 * cells.sum() / 1000) / (3 * cells.mean())
    written = combined_weights(phi, alpha, areas, 0.3, rate)
    np.fill_diagonal(written, 0)
    close(sigma, written)


def test_reference_points_none_switches_the_rules_of_size_off(figure):
    rules = Departures().as_written(*SIZE_RULES)
    one = Diffusion.from_points(*figure, modes=10, reference_points=None)
    other = Diffusion.from_points(*figure, modes=10, departures=rules)
    assert (one.eigenfunctions == other.eigenfunctions).all()
    assert one.parameters["departures"] == other.parameters["departures"] == asdict(rules)
    default = Diffusion.from_points(*figure, modes=10)
    assert default.parameters["departures"] == asdict(Departures())


def test_without_the_rules_of_size_points_count_as_one_each_and_no_rate_is_changed(figure):
    """Eqs. 4-7 with a cap and a cut-off, Eqs. 14-15, and the dense eigenproblem of Eq. 8."""
    found = Diffusion.from_points(*figure, modes=10, reference_points=None)
    phi = similarity_matrix(*figure, cutoff=1e-6, r_cap=smallest_width(figure[0]))
    alpha = gaussian_weights(figure[0], surface_areas(*figure)).weights.toarray()
    areas, sigma = found.areas, combined_weights(phi, alpha, found.areas, 0.5)
    np.fill_diagonal(sigma, 0)
    stiffness = np.diag(areas * (sigma @ areas)) - areas[:, None] * sigma * areas
    values = eigh(stiffness, np.diag(areas), eigvals_only=True)
    assert found.eigenvalues[1:] == pytest.approx(values[1:10], rel=1e-4)


def test_heat_operator_takes_one_bandwidth(figure):
    cloud = check_cloud(*figure)
    stiffness, areas, _, _ = build_operator(cloud, Operator(operator="heat", departures="none"))
    h = 3 * areas.mean()
    f = np.random.default_rng(0).standard_normal(POINTS)
    close(stiffness @ f / areas, point_cloud_laplacian(f, 4 / (np.pi * h**2) * gaussian(figure[0], h), areas))


def test_values():
    assert Departures.of("all") == Departures() == Departures.of({})
    assert Departures.of("none") == Departures.of(dict.fromkeys(asdict(NONE), False)) == NONE
    assert Departures.of(NONE) is NONE
    assert not Departures.of({"radius_cap": False}).radius_cap
    with pytest.raises(InputError, match="unknown departure 'cap'"):
        Departures.of({"cap": False})


@pytest.fixture(scope="module")
def written(figure):
    return Diffusion.from_points(*figure, modes=40, departures="none")


def test_matching_and_symmetry_follow_the_operator(figure, written):
    """Sec. 4 in the clouds' own units (Eqs. 16-17), and Sec. 5.2: a cloud is matched to itself."""
    found = match(written, written, seed=1)
    assert found.config == MatchConfig.paper(NONE)
    assert np.array_equal(
        prepare_pair(written, written, None, 1).source.descriptors.psi,
        written.eigenfunctions.astype(np.float32),
    )
    assert np.array_equal(intrinsic_symmetry(written, seed=1).source_to_target, found.source_to_target)
    assert match(written, written, "default").config == MatchConfig(departures=NONE)
    ours = Diffusion.from_points(*figure, modes=40)
    assert prepare_pair(ours, ours, "paper", 1).config == MatchConfig.paper(Departures())
    with pytest.raises(InputError, match="different departures"):
        match(written, ours)


def test_settings_of_the_matcher_take_words_and_refuse_others_at_once():
    assert MatchConfig(departures="none").departures == NONE
    assert MatchConfig.of(None, only("radius_cap")) == MatchConfig(departures=only("radius_cap"))
    with pytest.raises(InputError, match="departures is 'some'"):
        MatchConfig(departures="some")
    with pytest.raises(InputError, match="match config is 'papr'; give 'default', 'paper'"):
        MatchConfig.of("papr", NONE)


def test_unknown_departures_are_named():
    for make in (lambda: Departures(radius=False), lambda: Departures().as_written("radius")):
        with pytest.raises(InputError, match="unknown departure 'radius'; did you mean 'radius_cap'"):
            make()
    with pytest.raises(InputError, match="departure radius_cap must be true or false, got 'false'"):
        Departures(radius_cap="false")
    assert pickle.loads(pickle.dumps(NONE)) == NONE


def test_a_flat_cloud_has_no_medial_points_and_takes_its_surface_cells():
    """No ball touches a plane twice."""
    points = np.column_stack([np.random.default_rng(0).random((60, 2)), np.zeros(60)])
    normals = np.tile([0.0, 0.0, 1.0], (60, 1))
    flat = medial_diffusion(points, normals)
    assert np.isnan(flat.centers).all()
    assert flat.areas == pytest.approx(surface_areas(points, normals))
    assert np.isnan(dual_area(3, np.array([1, 2]), points, points[3], 1.0))
