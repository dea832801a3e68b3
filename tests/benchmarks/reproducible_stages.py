"""Where two runs part: ``python -m tests.benchmarks.reproducible_stages SCANS CHANGE PAIR``.

SCANS is the folder of scans that ``tests.benchmarks.reproducibility --folder`` keeps (``scans/scans`` in it),
CHANGE one of its changes that keep the order of points, PAIR one of its pairs. Matches the pair before and
after the change and prints what differs after each stage. Then stages of the second run are replaced by those
of the first, to see from which one on the rest follows.
"""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from medial import Diffusion, MatchConfig
from medial.matching import prepared
from medial.matching.candidate_batches import first_batch, first_landmarks_of, second_batch
from medial.matching.fit_search import search_from
from medial.matching.nearest import single_blas_thread
from medial.matching.prepared import PreparedPair, prepare_pair
from medial.matching.registration.direction import pair_directions
from medial.matching.registration.placement import Placement, place
from medial.matching.registration.selection import FineSelection
from scanner_sim import Scan
from tests.benchmarks.reproducible_maps import CHANGES, MODES, Pair

Int = NDArray[np.int64]


class Run(NamedTuple):
    """What a run holds after each stage."""

    diffusions: list[Diffusion]
    pair: PreparedPair
    landmarks: list[Int]
    placement: Placement
    mapped: Int


def run(diffusions: list[Diffusion], seed: int, samples: list[Int] | None = None) -> Run:
    """Match two diffusions as `medial.match` does, with samples of another run if they are given."""
    drawn = prepared._samples
    if samples is not None:
        prepared._samples = lambda *_: samples
    try:
        with single_blas_thread():
            pair = prepare_pair(*diffusions, MatchConfig(), seed)
            directions = pair_directions(pair)
            starts = first_landmarks_of(directions)
            first = first_batch(directions, starts)
            fits = search_from(directions, first, lambda: second_batch(directions, starts)).fits
            placements = [place(fit) for fit in fits]
            selection = FineSelection(fits, placements, pair.config)
            best = selection.finalists()[0]
            mapped = selection.dense(best).match
    finally:
        prepared._samples = drawn
    return Run(diffusions, pair, [each.landmarks for each in first], placements[best.number], mapped)


def apart(one: Any, other: Any) -> float:
    """Largest difference relative to the largest value."""
    return float(np.abs(one - other).max() / np.abs(one).max())


def lost(one: Int, other: Int) -> float:
    """Share of points of a set that are not in the other."""
    return 1 - len(np.intersect1d(one, other)) / len(one)


def differences(one: Run, other: Run) -> dict[str, str]:
    """What differs between two runs, stage by stage; where there are two clouds, the larger difference."""
    both = list(zip(one.diffusions, other.diffusions, strict=True))
    clouds = [(one.pair.source, other.pair.source), (one.pair.target, other.pair.target)]
    modes = [np.abs(np.einsum("nk,n,nk->k", a.eigenfunctions, a.areas, b.eigenfunctions)) for a, b in both]
    ends = one.pair.target.cloud.points
    changed = one.mapped != other.mapped
    gap = 100 * np.linalg.norm(ends[one.mapped] - ends[other.mapped], axis=1)
    sets = np.mean([np.array_equal(a, b) for a, b in zip(one.landmarks, other.landmarks, strict=False)])
    here = max(apart(a.coordinates, b.coordinates) for a, b in clouds)
    samples = max(lost(a.descriptors.samples, b.descriptors.samples) for a, b in clouds)
    cover = np.mean([(a.cover != b.cover).mean() for a, b in clouds])
    same = np.array_equal(one.pair.source.descriptors.samples, other.pair.source.descriptors.samples)
    moved = f"{100 * one.placement.gap(other.placement):.3f}" if same else "(other samples)"
    return {
        "areas, relative": f"{max(apart(a.areas, b.areas) for a, b in both):.0e}",
        "medial centres, relative": f"{max(apart(a.centers, b.centers) for a, b in both):.0e}",
        "eigenvalues, relative": f"{max(apart(a.eigenvalues, b.eigenvalues) for a, b in both):.0e}",
        "eigenfunctions, 1 - |<a, b>|": f"{max(float((1 - each).max()) for each in modes):.0e}",
        "coordinates of neighbourhoods, relative": f"{here:.0e}",
        "cover: another point at a rank": f"{100 * cover:.1f} %",
        "samples: others": f"{100 * samples:.1f} %",
        "landmark sets: others": f"{100 * (1 - sets):.1f} %",
        "samples placed elsewhere by, x 100 / sqrt(area)": moved,
        "matches changed": f"{100 * changed.mean():.1f} %",
        "by, x 100 / sqrt(area)": f"{gap[changed].mean() if changed.any() else 0:.2f}",
    }


def main() -> None:
    """Print the table."""
    folder, change, name = sys.argv[1:]
    pair = Pair.of(name)
    made: list[list[Diffusion]] = [[], []]
    for side, path in enumerate(pair.scans(Path(folder))):
        scan = Scan.load(path)
        for which, each in enumerate(("none", change)):
            cloud = CHANGES[each](scan.points, scan.normals, np.random.default_rng([pair.seed, side]))
            made[which].append(Diffusion.from_points(cloud.points, cloud.normals, modes=MODES))
    before, after = (run(each, pair.seed) for each in made)
    samples = [each.descriptors.samples for each in (before.pair.source, before.pair.target)]
    same_operators = [
        replace(old, points=new.points, normals=new.normals) for old, new in zip(*made, strict=True)
    ]
    columns = {
        change: differences(before, after),
        "with the same samples": differences(before, run(made[1], pair.seed, samples)),
        "with the same operators": differences(before, run(same_operators, pair.seed)),
    }
    _say(f"| {name} | {' | '.join(columns)} |")
    _say("|---|" + len(columns) * "---|")
    for row in next(iter(columns.values())):
        _say(f"| {row} | {' | '.join(column[row] for column in columns.values())} |")


def _say(line: str) -> None:
    print(line, flush=True)  # noqa: T201


if __name__ == "__main__":
    main()
