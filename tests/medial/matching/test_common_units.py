"""Two clouds in common units."""

from dataclasses import replace

import numpy as np
import pytest

from medial import Diffusion, MatchConfig, match
from medial.matching.common_units import GROSS, common_units, in_source_units, relative_scale, rescaled, sizes
from medial.spectrum.times import logarithmic_times
from tests.medial.clouds import body, rotation, sphere
from tests.medial.posed import figure


def scaled(n, seed, factor):
    points, normals = body(n, seed)
    return Diffusion.from_points(factor * points @ rotation(seed).T, normals @ rotation(seed).T, modes=40)


@pytest.mark.parametrize("factor", [1000.0, 0.01])
def test_other_units_are_recognized(factor):
    assert relative_scale(figure(), scaled(500, 1, factor)) * factor == pytest.approx(1, rel=0.1)


@pytest.mark.parametrize("factor", [0.85, 1.0, 1.2])
def test_small_differences_of_size_are_kept(factor):
    assert relative_scale(figure(), scaled(500, 1, factor)) == 1


@pytest.mark.parametrize("factor", [1.3, 1 / 1.3])
def test_smaller_differences_are_recognized_where_all_estimates_agree(factor):
    assert relative_scale(figure(), scaled(500, 1, factor)) * factor == pytest.approx(1, rel=0.1)
    other = replace(figure(), radii=1.3 * figure().radii, areas=1.3 * figure().areas)  # as with data missing
    assert relative_scale(figure(), other) == 1


def test_surface_operators_compare_area_and_extent():
    flat = replace(figure(), radii=np.zeros(len(figure())), operator="robust")
    large = replace(flat, points=10 * flat.points, areas=100 * flat.areas)
    assert relative_scale(flat, large) == pytest.approx(0.1)


@pytest.mark.parametrize("factor", [0.25, 4.0])
@pytest.mark.parametrize("wrong", [["areas"], ["radii"], ["areas", "radii"]])
def test_estimates_that_disagree_do_not_change_the_units(wrong, factor):
    """Balls that span two legs have large radii, and half a surface has half the area."""
    off = replace(figure(), **{name: getattr(figure(), name) * factor for name in wrong})
    assert relative_scale(figure(), off) == 1
    assert relative_scale(off, figure()) == 1


def test_part_of_a_body_keeps_its_units():
    """Area and extent shrink together; the radii tell."""
    points, normals = body(500, 1)
    upper = points[:, 2] > 0.2
    part = Diffusion.from_points(points[upper], normals[upper], modes=40)
    radius, side, extent = np.divide(sizes(figure()), sizes(part))
    assert radius == pytest.approx(1, rel=0.05)
    assert min(side, extent) > GROSS
    assert relative_scale(figure(), part) == 1


def test_sizes_of_a_ball():
    points, normals = sphere(1000, 2.0)
    radius, side, extent = sizes(Diffusion.from_points(points, normals, modes=10))
    assert radius == pytest.approx(2, rel=0.02)
    assert side == pytest.approx(np.sqrt(16 * np.pi), rel=0.02)
    assert extent == pytest.approx(2, rel=1e-3)


def test_common_units_are_those_of_the_larger_area():
    small = figure()
    points, normals = body(500, 1)
    half = points[:, 2] > -0.2
    other = Diffusion.from_points(1000 * points[half], normals[half], modes=40)
    here, there = common_units(small, other)
    unit = np.sqrt(small.areas.sum())
    assert np.allclose(here.points * unit, small.points)
    assert np.allclose(here.radii * unit, small.radii)
    factor = unit * relative_scale(other, small)  # of the other's points, in its own units
    assert np.allclose(there.points * factor, other.points)
    assert np.allclose(there.centers * factor, other.centers)
    again, first = common_units(other, small)
    assert np.ptp(again.points, axis=0) == pytest.approx(np.ptp(there.points, axis=0), rel=1e-9)
    assert np.ptp(first.points, axis=0) == pytest.approx(np.ptp(here.points, axis=0), rel=1e-9)
    assert here.features.shape == (len(small), 6)


KINDS = [("medial", 0.5), ("medial", None), ("heat", 0.5), ("robust", 0.5)]
BY_COST = replace(MatchConfig.paper(), samples=200)


@pytest.fixture(scope="module", params=KINDS, ids=lambda kind: "-".join(map(str, kind)))
def built(request):
    """A cloud, another one of the same body, and that one 1000 times larger, in one kind of operator."""
    operator, eta = request.param
    (points, normals), (others, other_normals) = body(500, 0), body(500, 1)
    return [
        Diffusion.from_points(p, n, operator, modes=60, eta=eta)
        for p, n in ((points, normals), (others, other_normals), (1000 * others, other_normals))
    ]


def test_a_rescaled_diffusion_is_that_of_the_scaled_points(built):
    _, small, large = built
    found = rescaled(large, 1e-3)
    np.testing.assert_allclose(found.points, small.points)
    np.testing.assert_allclose(found.areas, small.areas, rtol=1e-6)
    np.testing.assert_allclose(found.radii, small.radii, rtol=1e-6)
    np.testing.assert_allclose(found.centers, small.centers, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(found.eigenvalues[1:], small.eigenvalues[1:], rtol=1e-4)
    weighted = found.eigenfunctions * found.areas[:, None]
    np.testing.assert_allclose(found.eigenfunctions.T @ weighted, np.eye(60), atol=1e-6)


def test_clouds_in_the_same_units_are_left_alone(built):
    source, target, _ = built
    assert in_source_units(source, target) == (source, target)


def test_shared_times_resolve_a_cloud_in_other_units(built):
    """In the target's own units all its modes would be there at every time, or none."""
    source, _, large = built
    both = in_source_units(source, large)
    times = logarithmic_times(*(each.eigenvalues for each in both), count=3)
    for each in both:
        first, _, last = each.heat_trace(times)
        assert first > 1.5
        assert last < 1.5


def test_eqs_16_and_17_find_the_same_in_other_units(built):
    source, target, large = built
    before, after = (match(source, each, BY_COST, seed=1).source_to_target for each in (target, large))
    gap = np.linalg.norm(target.points[before] - target.points[after], axis=1)
    assert np.median(gap) < 0.1 * np.sqrt(target.areas.sum())
