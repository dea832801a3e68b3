import numpy as np
import pytest

import datasets_gen
from medial import Diffusion, intrinsic_symmetry
from medial.symmetry import mirror_image
from scanner_sim import sample


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
    diffusion = Diffusion.from_points(scan.points, scan.normals, modes=30, surface=True)
    image = mirror_image(diffusion)
    again = Diffusion.from_points(image.points, image.normals, modes=30)
    assert np.allclose(again.eigenvalues, diffusion.eigenvalues, rtol=1e-4, atol=1e-6)
