"""Time and memory of one match, in a process of its own: ``python -m tests.benchmarks.match_stages N``.

Options name other scans than two of the built-in human, a fifth of whose surface is missing: ``--dataset``
(built in, or a folder of posed meshes), ``--poses``, ``--threshold``, ``--views``.
"""

import argparse
import json
import sys

import numpy as np

import datasets_gen
from medial import Diffusion, match
from scanner_sim import ScannerConfig, scan
from tests.benchmarks.measuring import measured


def main(
    points: int, dataset: str, poses: tuple[str, str], threshold: float, views: int
) -> dict[str, float | None]:
    """Match two scans; their operators are not part of the time."""
    body = datasets_gen.load(dataset)
    config = ScannerConfig(views=views)
    whole = [scan(body[pose], config).accept(threshold) for pose in poses]
    small = [Diffusion.from_points(s.points, s.normals, modes=60) for s in (w.subsample(800) for w in whole)]
    match(*small)  # kernels are loaded
    scans = [w.subsample(points) for w in whole]
    operators = [Diffusion.from_points(s.points, s.normals) for s in scans]
    found, (wall, processor, peak) = measured(match, *operators)
    truth = [body.canonical(body[p], s.face_ids, s.barycentrics) for p, s in zip(poses, scans, strict=True)]
    error = np.linalg.norm(truth[1][found.source_to_target] - truth[0], axis=1)
    return {
        "points": float(np.mean([len(s) for s in scans])),
        "wall": wall,
        "processor": processor,
        "peak MB": peak,
        "error": 100 * float(error.mean() / np.sqrt(body.reference.area)),
    }


if __name__ == "__main__":
    parser = argparse.ArgumentParser()
    parser.add_argument("points", type=int)
    parser.add_argument("--dataset", default="human")
    parser.add_argument("--poses", nargs=2, default=("walk", "run"))
    parser.add_argument("--threshold", type=float, default=0.8)
    parser.add_argument("--views", type=int, default=6)
    sys.stdout.write(json.dumps(main(**vars(parser.parse_args()))) + "\n")
