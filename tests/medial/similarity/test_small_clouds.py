"""The search for similar pairs on clouds so small that every step of it can be followed without Numba."""

import numpy as np
import pytest

from medial import Departures, dual_areas, medial_axis, similarity, surface_areas
from medial.areas.equations import medial_averages
from medial.operator import Operator, medial_weights
from medial.similarity.candidate_ball import smallest_width
from medial.similarity.equations import similarity_matrix
from medial.validation import check_cloud
from tests.medial import clouds
from tests.medial.areas.test_dual_area import written_areas

pytestmark = pytest.mark.uncompiled
SHAPES = {
    "sphere": clouds.sphere(50),
    "cylinder": clouds.cylinder(70),
    "body with a hole": clouds.body(80, holes=1),
    "no structure": clouds.random_cloud(50),
}


@pytest.mark.parametrize("name", SHAPES)
def test_similarities_are_those_of_equations_4_to_7(name):
    points, normals = SHAPES[name]
    settings = {"sigma_e": 2.0, "cutoff": 1e-6}
    written = similarity_matrix(points, normals, r_cap=smallest_width(points), **settings)
    assert (written > 0).sum() > 50
    assert np.abs(similarity(points, normals, **settings).toarray() - written).max() < 5e-6


def test_medial_points_and_radii_are_those_of_equation_9():
    points, normals = SHAPES["cylinder"]
    phi = similarity(points, normals)
    centers, radii = medial_axis(points, normals, phi)
    written_centers, written_radii = medial_averages(points, normals, phi.toarray())
    some = written_radii > 0
    assert some.mean() > 0.8
    assert centers[some] == pytest.approx(written_centers[some], abs=1e-9)
    assert radii[some] == pytest.approx(written_radii[some], abs=1e-9)


@pytest.mark.parametrize("name", ["cylinder", "body with a hole"])
def test_dual_areas_are_those_of_equation_10(name):
    points, normals = SHAPES[name]
    centers, radii = medial_axis(points, normals, similarity(points, normals))
    written = written_areas(points, centers, radii, nearest=6)
    some = np.isfinite(written)
    assert some.mean() > 0.6
    assert dual_areas(points, centers, radii, nearest=6)[some] == pytest.approx(written[some], rel=1e-9)


def test_without_any_departure_every_pair_counts():
    figure = SHAPES["cylinder"]
    config = Operator(departures=Departures.none(), eta=None)
    found = medial_weights(check_cloud(*figure), surface_areas(*figure), config)[0].toarray()
    assert found == pytest.approx(similarity_matrix(*figure), rel=1e-9, abs=1e-12)
