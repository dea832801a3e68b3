"""Time and peak memory of every stage of the medial operator, as JSON on standard output.

    python -m tests.benchmarks.operator_stages POINTS [MODES] [--plain] [--cuda | --llvm]

Run as a process of its own, so that the memory of one size is not counted for another.
"""

import json
import sys
import time

import numpy as np
from trimesh import Trimesh

from datasets_gen import load
from medial.areas.dual_area import JOINED, calibrated, dual_areas, medial_axis
from medial.areas.surface_cells import REFERENCE_POINTS, density_weights, surface_areas
from medial.laplacian.weights import combine, diffusion_rates, gaussian_weights, laplacian
from medial.similarity.candidate_ball import smallest_width
from medial.similarity.emptiness import Settings
from medial.similarity.every_pair import similar_among_all
from medial.similarity.similarity import similarity
from medial.sparse import symmetric
from medial.spectrum.modes import smallest_modes
from medial.validation import check_cloud
from tests.benchmarks.measuring import measured
from tests.medial.clouds import thinned


def scanned(points):
    """The built-in human at rest, all of its surface."""
    shape = load("human").reference
    random = np.random.default_rng(0)
    faces = random.choice(len(shape.faces), 12 * points, p=shape.face_areas / shape.area)
    weights = random.dirichlet(np.ones(3), 12 * points)
    mesh = Trimesh(shape.vertices, shape.faces, process=False)
    normals = np.einsum("nc,ncd->nd", weights, mesh.vertex_normals[shape.faces[faces]])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return thinned(shape.at(faces, weights), normals, points)


def plain_similarity(points, normals, weights, cutoff=1e-6):
    """The same pair by pair, with the obvious savings only (`medial.similarity.every_pair`)."""
    settings = Settings(5.0, 0.7, -np.log(cutoff), smallest_width(points), cutoff)
    parts = list(similar_among_all(check_cloud(points, normals), settings, weights))
    return symmetric(*(np.concatenate([part[k] for part in parts]) for k in range(3)), len(points))


def stages(points, normals, modes, plain=False, device="cpu"):
    """Seconds, processor seconds and peak megabytes by stage, and sizes."""
    report = {"points": len(points)}

    def timed(name, function, *args, **kwargs):
        result, report[name] = measured(function, *args, **kwargs)
        return result

    surface = timed("surface", surface_areas, points, normals)
    weights = density_weights(surface)
    phi = timed("similarity", similarity, points, normals, weights=weights, device=device)
    centers, radii = timed("axis", medial_axis, points, normals, phi)
    areas = calibrated(timed("areas", dual_areas, points, centers, radii, normals, JOINED), surface)
    alpha, bandwidths = timed("gaussian", gaussian_weights, points, surface)
    rates = diffusion_rates(bandwidths, surface.sum(), REFERENCE_POINTS)
    sigma = timed("combination", combine, phi, alpha, areas, 0.5, rates)
    stiffness = timed("laplacian", laplacian, sigma, areas)
    *_, report["residual"] = timed("modes", smallest_modes, stiffness, areas, modes, device=device)
    report["phi per row"], report["sigma per row"] = phi.nnz / len(points), sigma.nnz / len(points)
    if plain:
        slow = timed("plain", plain_similarity, points, normals, weights)
        report["difference"] = float(abs(phi - slow).max())
    return report


def main(arguments):
    numbers = [int(each) for each in arguments if each.isdigit()]
    points, modes = [*numbers, 300][:2]
    plain = "--plain" in arguments
    device = next((name for name in ("cuda", "llvm") if f"--{name}" in arguments), "cpu")
    cold = time.perf_counter()
    stages(*scanned(1300), 20, plain, device)
    cold = time.perf_counter() - cold
    report = stages(*scanned(points), modes, plain, device)
    sys.stdout.write(json.dumps(report | {"first call": cold}) + "\n")


if __name__ == "__main__":
    main(sys.argv[1:])
