import numpy as np
import pytest

import datasets_gen
from datasets_gen.records import InputError
from medial import Departures, Diffusion, MatchConfig, intrinsic_symmetry, match
from medial.matching.common_units import common_units
from medial.matching.landmarks.medial_paths import MedialPaths
from medial.symmetry import mirror_image
from scanner_sim import sample
from tests.medial.clouds import sphere
from tests.medial.posed import figure, legs


@pytest.fixture(scope="module")
def human():
    return datasets_gen.load("human")


def symmetry_error(body, scan, found):
    """Distance on the rest pose between image and mirrored point, over the square root of the area."""
    rest = body.canonical(body.reference, scan.face_ids, scan.barycentrics)
    middle = body.reference.vertices[:, 0].mean()
    mirrored = rest * [-1, 1, 1] + [2 * middle, 0, 0]
    return np.linalg.norm(rest[found.source_to_target] - mirrored, axis=1) / np.sqrt(body.reference.area)


def test_a_body_is_mapped_to_its_mirror_side(human):
    scan = sample(human["walk"], 2500, seed=0)
    diffusion = Diffusion.from_points(scan.points, scan.normals, modes=100)
    found = intrinsic_symmetry(diffusion)
    assert np.mean(symmetry_error(human, scan, found)) < 0.05
    still = np.linalg.norm(scan.points[found.source_to_target] - scan.points, axis=1)
    assert np.median(still) > 0.1  # metres: not the identity
    assert np.median(found.confidence) > 0.5


@pytest.mark.slow
def test_a_scan_that_shows_front_and_back_alike_is_not_turned_front_to_back(human):
    """Seen from its left and from two sides behind and before, a body meets its mirror image turned round."""
    scan = sample(human["arms_up"], 4000, seed=0)
    side = np.deg2rad([0, 120, 240])
    views = np.column_stack([np.cos(side), 0 * side, np.sin(side)])
    scan = scan.select((scan.normals @ views.T).max(axis=1) > 0.75)
    diffusion = Diffusion.from_points(scan.points, scan.normals, modes=100)
    found = intrinsic_symmetry(diffusion)
    error = symmetry_error(human, scan, found)
    assert np.mean(error) < 0.05
    sure = found.confidence > 0.9
    assert sure.mean() > 0.1
    assert (error[sure] < 0.1).mean() > 0.9


def test_the_outer_half_has_the_limbs():
    outer = MedialPaths.of(common_units(figure(), figure())[0]).outer_half()
    assert 0.4 < outer.mean() <= 0.5
    assert outer[legs(figure().points)].mean() > 0.9


@pytest.mark.slow
@pytest.mark.long
def test_a_ball_has_no_symmetry_to_be_sure_of():
    points, normals = sphere(400)
    found = intrinsic_symmetry(Diffusion.from_points(points, normals, modes=30))
    assert (found.confidence < 0.5).all()


@pytest.mark.slow
def test_a_missing_arm_has_no_counterpart(human):
    scan = sample(human.reference, 2500, seed=0)
    there = scan.points[:, 0] < human.reference.vertices[:, 0].max() - 0.45  # one forearm cut off
    scan = scan.select(there)
    diffusion = Diffusion.from_points(scan.points, scan.normals, modes=100)
    found = intrinsic_symmetry(diffusion)
    alone = scan.points[:, 0] < -(human.reference.vertices[:, 0].max() - 0.4)
    assert np.median(found.confidence[alone]) < np.median(found.confidence[~alone]) / 2
    assert np.mean(symmetry_error(human, scan, found)[~alone]) < 0.05


def test_the_mirror_image_keeps_the_spectrum(human):
    scan = sample(human.reference, 800, seed=0)
    diffusion = Diffusion.from_points(scan.points, scan.normals, modes=30)
    image = mirror_image(diffusion)
    again = Diffusion.from_points(image.points, image.normals, modes=30)
    assert np.allclose(again.eigenvalues, diffusion.eigenvalues, rtol=1e-4, atol=1e-6)


def test_settings_that_cannot_find_a_symmetry_are_refused():
    with pytest.raises(InputError, match="selection = 'fit', got 'cost'"):
        intrinsic_symmetry(figure(), MatchConfig.paper())


def test_as_written_a_cloud_is_matched_to_itself():
    """Sec. 5.2 matches a cloud to itself, and the identity wins."""
    config = MatchConfig.paper(Departures().as_written("mirrored_symmetry"))
    found = intrinsic_symmetry(figure(), config, seed=1)
    assert np.array_equal(found.source_to_target, match(figure(), figure(), config, seed=1).source_to_target)
    gap = np.linalg.norm(figure().points[found.source_to_target] - figure().points, axis=1)
    assert np.median(gap) < 0.05
