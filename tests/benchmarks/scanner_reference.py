"""The scanner against the figures of the reference program: ``python -m tests.benchmarks.scanner_reference``.

Prints the tables of ``docs/scanner.md``: residual along the normal, points, normals and coverage of a sphere
of 75 mm seen from 9 views of 400 x 400 pixels, in the reference preset and with the other fit; and the
coverage of the built-in human by views and threshold.
"""

import sys
import time

import numpy as np
import trimesh

from datasets_gen import Shape, load
from scanner_sim import Scan, ScannerConfig, coverage, estimated_normals, scan

THRESHOLDS = (0.1, 0.5, 0.7, 0.8, 0.9)


def say(line: str) -> None:
    """Print a line at once: a table takes minutes."""
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def sphere() -> Shape:
    """A sphere of 75 mm whose facets are too small to matter."""
    mesh = trimesh.creation.icosphere(subdivisions=7, radius=37.5)
    return Shape(np.array(mesh.vertices), np.array(mesh.faces, np.int32), "sphere/75", "sphere", "75", "mm")


def residual(found: Scan) -> float:
    """Root mean square distance along the normal of a sphere about the origin, mm."""
    outward = found.true_points / np.linalg.norm(found.true_points, axis=1, keepdims=True)
    return float(np.sqrt((np.einsum("nd,nd->n", found.points - found.true_points, outward) ** 2).mean()))


def normal_error(found: Scan) -> float:
    """Mean angle between normals by PCA over all views and those of a sphere, degrees."""
    outward = found.true_points / np.linalg.norm(found.true_points, axis=1, keepdims=True)
    cosine = np.einsum("nd,nd->n", estimated_normals(found, "pca_true_sign", 11), outward)
    return float(np.degrees(np.arccos(np.clip(cosine, -1, 1))).mean())


def sphere_table() -> None:
    """One line per noise and fit."""
    shape = sphere()
    say(
        "| noise | fit | " + " | ".join(f"RMS at {t}" for t in THRESHOLDS) + " | points at .1, .9 | normals |"
        " coverage at .5, .7, .8, .9 | s a view |"
    )
    for noise in (0.0, 0.35):
        for fit in ("reference", "least_squares"):
            start = time.perf_counter()
            found = scan(shape, ScannerConfig.reference(noise=noise, fit=fit, normals="true"))
            seconds = (time.perf_counter() - start) / 9
            kept = {t: found.accept(t) for t in THRESHOLDS}
            rms = " | ".join(f"{residual(kept[t]):.4f}" for t in THRESHOLDS)
            points = ", ".join(f"{len(kept[t]) / 1000:.0f}k" for t in (0.1, 0.9))
            seen = ", ".join(f"{coverage(kept[t], shape):.3f}" for t in THRESHOLDS[1:])
            say(
                f"| {noise} | {fit} | {rms} | {points} | {normal_error(found):.2f} | {seen} | {seconds:.2f} |"
            )


def coverage_table() -> None:
    """Share of the surface of the human at rest within 1 % of the diagonal."""
    shape = load("human").reference
    thresholds = (0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95)
    say("| views | " + " | ".join(f"tau {t}" for t in thresholds) + " |")
    for views in ("opposed", "ring:4", 10):
        found = scan(shape, ScannerConfig(views=views, peak_threshold=0.1))
        seen = " | ".join(f"{coverage(found.accept(t), shape):.3f}" for t in thresholds)
        say(f"| {views} | {seen} |")


if __name__ == "__main__":
    sphere_table()
    coverage_table()
