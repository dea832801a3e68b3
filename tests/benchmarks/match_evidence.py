"""Weights of the evidence by which the matcher selects: ``python -m tests.benchmarks.match_evidence``.

The matcher compares finalists by a log-likelihood (`medial.matching.registration.evidence`). This collects
the finalists of many pairs of scans with their evidence and errors, fits the weights of the likelihood to the
pairs of all bodies but one, judges them on that one, and shows what halving and doubling the shipped weights
would change. ``--folder DIR`` adds a folder of posed meshes; ``-o FILE`` keeps the table, ``--fits FILE``
judges a kept one. Held-out bodies, seeds and poses (`datasets_gen.registry.held_out`) are refused.
"""

import argparse
import itertools
import sys
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.spatial import cKDTree

import datasets_gen
from datasets_gen.compiled import run_tasks
from datasets_gen.records import InputError
from datasets_gen.registry import held_out
from datasets_gen.values import check_count, check_seed
from medial import Diffusion
from medial.matching.candidate_batches import first_batch, first_landmarks_of, second_batch
from medial.matching.config import MatchConfig
from medial.matching.fit_search import search_from
from medial.matching.nearest import single_blas_thread
from medial.matching.prepared import prepare_pair
from medial.matching.registration.direction import DirectedFit, Direction, pair_directions
from medial.matching.registration.evidence import Weights
from medial.matching.registration.placement import path_change, place
from medial.matching.registration.selection import FineSelection
from scanner_sim import Scan, ScannerConfig, scan
from tests.benchmarks.choice_model import SET, SIGNS, foretold, left_out, none_right, sensitivity

Float = NDArray[np.float64]

BODIES = ("human", "quadruped")
CONFIG = MatchConfig(finalists=14)
"""More finalists than the matcher takes: wrong maps that come close are what the weights are for."""
QUICK = 2
"""Pairs of each body with ``--pairs quick``."""


class Regime(NamedTuple):
    """How the source and the target are scanned."""

    name: str
    source: int | str
    target: int | str
    threshold: float


REGIMES = (
    Regime("6 views, tau 0.7", 6, 6, 0.7),
    Regime("6 views, tau 0.9", 6, 6, 0.9),
    Regime("3 views, tau 0.8", 3, 3, 0.8),
    Regime("front to back, 2 cameras", "front:2", "back:2", 0.3),
    Regime("left to right, 2 cameras", "left:2", "right:2", 0.3),
    Regime("front to back, 1 camera", "front:1", "back:1", 0.3),
    Regime("left to right, 1 camera", "left:1", "right:1", 0.3),
)


def pairs_of(poses: tuple[str, ...], which: str, seed: int) -> list[tuple[str, str]]:
    """All pairs of poses, or `QUICK` of them, drawn."""
    every = list(itertools.combinations(poses, 2))
    if which == "all" or len(every) <= QUICK:
        return every
    drawn = np.random.default_rng(seed).choice(len(every), QUICK, replace=False)
    return [every[k] for k in sorted(drawn)]


def fits_of(directions: list[Direction]) -> list[DirectedFit]:
    """What the matcher's search ends with (`medial.matching.fit_search`)."""
    starts = first_landmarks_of(directions)
    first = first_batch(directions, starts)
    return search_from(directions, first, lambda: second_batch(directions, starts)).fits


def finalists_of(
    scans: tuple[Scan, Scan], error_of: Callable[[NDArray[np.int64]], float], seed: int
) -> list[dict[str, Any]]:
    """Evidence and error of each finalist of a pair of scans.

    Parameters
    ----------
    scans
    error_of
        Mean error of a map, target point of every source point.
    seed

    Returns
    -------
    list of dict
        ``score``, ``fine_strain``, ``medial`` and ``fine_missed`` are what the log-likelihood weighs;
        ``seen``, ``missed``, ``strain``, ``held`` and ``paths`` what the score does.
    """
    operators = [Diffusion.from_points(each.points, each.normals) for each in scans]
    with single_blas_thread():
        fits = fits_of(pair_directions(prepare_pair(operators[0], operators[1], CONFIG, seed)))
        placements = run_tasks(place, [(fit,) for fit in fits])
        selection = FineSelection(fits, placements, CONFIG)
        rows = []
        for rank, each in enumerate(selection.finalists()):
            quick = fits[each.number]
            rows.append(
                {
                    "finalist": rank,
                    "score": placements[each.number].score,
                    "quick_medial": quick.medial_gap,
                    "fine_strain": each.fit.strain,
                    "medial": each.medial_gap,
                    "fine_missed": each.fit.missed,
                    "fine_seen": each.fit.seen,
                    "log_likelihood": each.log_likelihood,
                    "error": error_of(selection.dense(each).match),
                    **{name: getattr(quick, name) for name in ("seen", "missed", "strain", "held")},
                    "paths": path_change(quick),
                }
            )
    return rows


def check_not_held_out(bodies: list[str]) -> None:
    """Raise InputError for the first body that is held out, or a folder into which one was written."""
    for name in bodies:
        if held_out(name):
            raise InputError(f"{name!r} is held out: no weight may be fitted to it; leave it out")


def collected(bodies: list[str], points: int, pairs: str, seed: int) -> Iterator[dict[str, Any]]:
    """Rows of the table of finalists, one pair of scans after the other."""
    for body in [datasets_gen.load(name) for name in bodies]:

        def scanned(pose: str, views: int | str, threshold: float, body: Any = body) -> Scan:
            whole = scan(body[pose], ScannerConfig(views=views), seed=seed)
            return whole.accept(threshold).subsample(points, seed=seed)

        for pair, regime in itertools.product(pairs_of(body.poses, pairs, seed), REGIMES):
            here = scanned(pair[0], regime.source, regime.threshold)
            there = scanned(pair[1], regime.target, regime.threshold)
            source, target = (
                body.canonical(body[pose], each.face_ids, each.barycentrics)
                for pose, each in zip(pair, (here, there), strict=True)
            )
            error_of = partial(straight_error, source, target, float(np.sqrt(body.reference.area)))
            nearest = cKDTree(target).query(source)[1]
            about = {"body": body.subject, "pair": "-".join(pair), "regime": regime.name}
            about |= {"least": error_of(nearest)}
            rows = finalists_of((here, there), error_of, seed)
            best = min(row["error"] for row in rows)
            sys.stderr.write(
                f"{body.subject}, {'-'.join(pair)}, {regime.name}: {len(rows)} finalists, best {best:.2f}\n"
            )
            yield from (about | row for row in rows)


def straight_error(source: Float, target: Float, length: float, match: NDArray[np.int64]) -> float:
    """Mean straight distance on the rest pose between matches and true places, x 100 / length.

    Parameters
    ----------
    source, target : (n, 3), (m, 3)
        True places.
    length
        sqrt(area) of the rest pose.
    match : (n,)
    """
    return 100 * float(np.linalg.norm(target[match] - source, axis=1).mean()) / length


def read(path: Path) -> pd.DataFrame:
    """A table that was kept.

    Raises
    ------
    InputError
        If it is missing or lacks a column.
    """
    try:
        table = pd.read_parquet(path)
    except (OSError, ValueError) as error:
        raise InputError(f"cannot read the fits {str(path)!r}: {error}") from error
    lacking = {
        *SET,
        *SIGNS,
        "error",
        "seen",
        "missed",
        "strain",
        "held",
        "paths",
        "quick_medial",
        "fine_seen",
        "least",
    } - {*table.columns}
    if lacking or table.empty:
        raise InputError(f"{str(path)!r} holds no fits; it lacks {', '.join(sorted(lacking)) or 'rows'}")
    return table


def report(table: pd.DataFrame) -> str:
    """Both tables as text."""
    weights = Weights()
    counts = f"{table.groupby(SET).ngroups} pairs of scans, {len(table)} finalists"
    with pd.option_context("display.float_format", "{:.4g}".format, "display.width", 200):
        return "\n".join(
            [
                counts,
                "\nWeights fitted to the other bodies, and the shipped ones, on the body left out",
                "(excess: error of the chosen finalist less that of the best, x 100 / sqrt(area)):\n",
                left_out(table, weights).to_string(index=False),
                "\nWhat quick fits of the other bodies foretell of the likelihood on the body left out:\n",
                foretold(table, weights).to_string(index=False),
                "\nThat none is right, fitted to the other bodies, on the body left out:\n",
                none_right(table, weights).to_string(index=False),
                "\nEach shipped weight halved and doubled; the search is not done again:\n",
                sensitivity(table, weights).to_string(index=False),
                "",
            ]
        )


def main() -> None:
    """Collect or read the fits, and print what they say."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--folder", action="append", default=[], metavar="DIR")
    parser.add_argument("--points", type=int, default=4000)
    parser.add_argument("--pairs", choices=("quick", "all"), default="quick")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--fits", type=Path, metavar="FILE")
    parser.add_argument("-o", "--out", type=Path, metavar="FILE")
    given = parser.parse_args()
    try:
        check_count(given.points, "points")
        check_seed(given.seed, "seed")
        if given.out and not given.out.absolute().parent.is_dir():
            raise InputError(f"cannot write {str(given.out)!r}: there is no such folder")
        check_not_held_out([*BODIES, *given.folder])
        if given.fits:
            table = read(given.fits)
        else:
            rows = collected([*BODIES, *given.folder], given.points, given.pairs, given.seed)
            table = pd.DataFrame(rows)
        if given.out:
            table.to_parquet(given.out, index=False)
    except InputError as error:
        parser.exit(2, f"{error}\n")
    sys.stdout.write(report(table))


if __name__ == "__main__":
    main()
