from importlib import import_module

import numpy as np
import pytest

from datasets_gen.records import InputError
from medial import similarity
from medial.similarity.candidate_ball import smallest_width
from medial.similarity.equations import similarity_matrix
from tests.medial import clouds

SINGLE = 5e-6  # what single precision may change in phi


def written(points, normals, *, cutoff=1e-6, r_cap=None, **settings):
    """Eqs. 4-7 with the same cut-off and radius cap."""
    cap = smallest_width(points) if r_cap is None else r_cap
    return similarity_matrix(points, normals, cutoff=cutoff, r_cap=cap, **settings)


@pytest.fixture(scope="module")
def figure():
    return clouds.body(700)


@pytest.fixture(scope="module")
def phi(figure):
    return similarity(*figure)


@pytest.mark.parametrize("holes", [0, 8])
@pytest.mark.parametrize(
    "settings", [{}, {"cutoff": 1e-3}, {"sigma_e": 9.0, "sigma_t": 1.2}, {"sigma_e": 0.5}]
)
def test_equals_the_equations(holes, settings):
    points, normals = clouds.body(500, holes=holes)
    fast, slow = similarity(points, normals, **settings), written(points, normals, **settings)
    assert np.abs(fast.toarray() - slow).max() < SINGLE
    assert (fast.toarray() > 0).sum() == pytest.approx((slow > 0).sum(), abs=4)


@pytest.mark.slow
@pytest.mark.long
@pytest.mark.parametrize("holes", [0, 8])
def test_equals_the_equations_at_2000_points(holes):
    points, normals = clouds.body(2000, holes=holes)
    fast, slow = similarity(points, normals), written(points, normals)
    assert np.abs(fast.toarray() - slow).max() < SINGLE


@pytest.mark.parametrize("shape", ["torus", "cylinder", "planes"])
def test_equals_the_equations_on_other_shapes(shape):
    points, normals = getattr(clouds, shape)(400)
    weights = np.random.default_rng(0).uniform(0.2, 3, 400)
    fast = similarity(points, normals, weights=weights).toarray()
    assert np.abs(fast - written(points, normals, weights=weights)).max() < SINGLE


def test_equals_the_equations_without_structure():
    """Random points and normals: nothing that the culling relies on holds."""
    random = np.random.default_rng(3)
    points, normals = random.standard_normal((300, 3)), random.standard_normal((300, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    fast = similarity(points, normals, sigma_e=20, cutoff=1e-9).toarray()
    assert np.abs(fast - written(points, normals, sigma_e=20, cutoff=1e-9)).max() < SINGLE


def test_uneven_sampling_and_distant_parts():
    points, normals = clouds.body(400)
    shifted = np.concatenate([points, 0.05 * points[:200] + [30.0, 0, 0]])
    both = np.concatenate([normals, normals[:200]])
    fast = similarity(shifted, both, r_cap=0.6).toarray()
    assert np.abs(fast - written(shifted, both, r_cap=0.6)).max() < SINGLE
    assert not fast[:400, 400:].any()


def test_sphere_is_one_medial_region():
    points, normals = clouds.sphere(400)
    phi = similarity(points, normals).toarray()
    assert phi[~np.eye(400, dtype=bool)].min() > 0.999
    assert not phi.diagonal().any()


def test_points_of_a_cylinder_are_similar_around_it_and_not_along_it():
    points, normals = clouds.cylinder(800)
    phi = similarity(points, normals).tocoo()
    along = np.abs(points[phi.row, 2] - points[phi.col, 2])
    assert np.average(along, weights=phi.data) < 0.3
    around = np.einsum("ij,ij->i", normals[phi.row], normals[phi.col])
    assert np.average(around < -0.9, weights=phi.data) > 0.1


def test_symmetric_to_the_bit(phi):
    assert (phi != phi.T).nnz == 0
    assert not phi.diagonal().any()
    assert phi.has_canonical_format


def test_order_of_points_does_not_matter(figure, phi):
    order = np.random.default_rng(1).permutation(700)
    again = similarity(figure[0][order], figure[1][order])
    assert (again != phi[order][:, order]).nnz == 0


@pytest.mark.parametrize("threads", [1, 3])
def test_number_of_threads_does_not_matter(figure, phi, threads, monkeypatch):
    monkeypatch.setattr("datasets_gen.compiled.thread_count", lambda: threads)
    assert (similarity(*figure) != phi).nnz == 0


def test_size_of_batches_does_not_matter(figure, phi, monkeypatch):
    monkeypatch.setattr(import_module("medial.similarity.similarity"), "PAIRS_AT_ONCE", 1)
    assert abs(similarity(*figure) - phi).max() < SINGLE


@pytest.mark.parametrize(("scale", "shift"), [(1.0, 0.0), (1000.0, 0.0), (1e-3, 5.0), (1.0, 300.0)])
def test_invariant_to_motion_and_scale(figure, phi, scale, shift):
    turn = clouds.rotation(4)
    moved = similarity(scale * (figure[0] + shift) @ turn.T, figure[1] @ turn.T)
    assert abs(moved - phi).max() < 5e-5


def test_weights_count_points(figure):
    """A point of weight 2 is as good as two points there."""
    points, normals = figure[0][:400], figure[1][:400]
    doubled = similarity(np.repeat(points, 2, axis=0), np.repeat(normals, 2, axis=0)).toarray()[::2, ::2]
    weighted = similarity(points, normals, weights=np.full(400, 2.0)).toarray()
    assert doubled == pytest.approx(weighted, abs=SINGLE)


def test_radius_cap_defaults_to_the_smallest_width(figure, phi):
    same = similarity(*figure, r_cap=smallest_width(figure[0]))
    assert (same != phi).nnz == 0
    assert similarity(*figure, r_cap=0.05).nnz < phi.nnz


@pytest.mark.parametrize("axes", [[0, 1], [0]], ids=["plane", "line"])
def test_flat_clouds_have_no_medial_balls(axes):
    points, normals = np.zeros((100, 3)), np.tile([0.0, 0, 1], (100, 1))
    points[:, axes] = np.random.default_rng(0).uniform(size=(100, len(axes)))
    assert similarity(points, normals).nnz == 0


def test_too_round_for_memory_is_an_input_error(monkeypatch):
    monkeypatch.setattr(import_module("medial.similarity.similarity"), "MOST_PAIRS", 1000)
    with pytest.raises(InputError, match="close to a ball"):
        similarity(*clouds.sphere(100))


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"cutoff": 0}, "cutoff is 0"),
        ({"cutoff": 2.0}, "cutoff"),
        ({"sigma_e": -1}, "sigma_e is -1"),
        ({"sigma_t": 0}, "sigma_t"),
        ({"weights": np.ones(3)}, "weights"),
    ],
)
def test_bad_settings(figure, settings, message):
    with pytest.raises(InputError, match=message):
        similarity(*figure, **settings)


def _broken(name):
    points, normals = clouds.sphere(50)
    if name == "nan":
        points[3, 1] = np.nan
    elif name == "infinite normal":
        normals[3, 1] = np.inf
    elif name == "zero normal":
        normals[3] = 0
    elif name == "few":
        points, normals = points[:5], normals[:5]
    elif name == "flat shape":
        points = points[:, :2]
    elif name == "lengths":
        normals = normals[:-1]
    return points, normals


@pytest.mark.parametrize("name", ["nan", "infinite normal", "zero normal", "few", "flat shape", "lengths"])
def test_bad_clouds(name):
    with pytest.raises(InputError) as error:
        similarity(*_broken(name))
    assert "\n" not in str(error.value)


def test_normals_of_any_length_are_normalised(figure, phi, caplog):
    scaled = similarity(figure[0], 3.0 * figure[1])
    assert abs(scaled - phi).max() < 1e-6
    assert "normalised" in caplog.text
