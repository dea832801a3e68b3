"""Time and memory of one match, in a process of its own: ``python -m tests.benchmarks.match_stages N``."""

import json
import sys

import numpy as np

import datasets_gen
from medial import Diffusion, match
from scanner_sim import ScannerConfig, scan
from tests.benchmarks.measuring import measured

POSES = ("walk", "run")


def main(points: int) -> dict[str, float | None]:
    """Match two scans of the built-in human, a fifth of whose surface is missing."""
    body = datasets_gen.load("human")
    config = ScannerConfig(views=6)
    whole = [scan(body[pose], config).accept(0.8) for pose in POSES]
    small = [Diffusion.from_points(s.points, s.normals, modes=60) for s in (w.subsample(800) for w in whole)]
    match(*small)  # kernels are loaded
    scans = [w.subsample(points) for w in whole]
    operators = [Diffusion.from_points(s.points, s.normals) for s in scans]
    found, (wall, processor, peak) = measured(match, *operators)
    truth = [body.canonical(body[p], s.face_ids, s.barycentrics) for p, s in zip(POSES, scans, strict=True)]
    error = np.linalg.norm(truth[1][found.source_to_target] - truth[0], axis=1)
    return {
        "points": float(np.mean([len(s) for s in scans])),
        "wall": wall,
        "processor": processor,
        "peak MB": peak,
        "error": 100 * float(error.mean() / np.sqrt(body.reference.area)),
    }


if __name__ == "__main__":
    sys.stdout.write(json.dumps(main(int(sys.argv[1]))) + "\n")
