"""What a map's probability and a point's confidence are worth: ``python -m tests.benchmarks.trust RESULTS``.

Reads the maps of results folders whose method states a probability, and prints a table in Markdown: of the
maps whose probability lies in a range, how many have the limbs right, how many points are confident, and how
many of these are right (error below 10, x 100 / sqrt(area)). ``--apart TEXT`` (repeatable) gives regimes
whose name contains a text rows of their own. docs/matching.md has such a table.
"""

import argparse
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from datasets_gen.records import InputError
from evaluation.metrics.correspondence import RIGHT
from evaluation.results.store import ResultsStore
from reports.figures.pair_pictures import PairMaker
from reports.figures.result_figures import PAIR
from reports.tables.leaderboard import with_numpy_types

RANGES = {"below .5": (0.0, 0.5), ".5 to .8": (0.5, 0.8), ".8 and more": (0.8, np.inf)}
LIMBS = 0.9
"""Share of right limbs from which a map is right."""
CONFIDENT = (0.5, 0.9)


class Judged(NamedTuple):
    """A map against the truth."""

    regime: str
    probability: float
    right_limb: float
    confident: tuple[int, ...]
    right: tuple[int, ...]
    points: int


def judged(folder: Path) -> Iterator[Judged]:
    """The maps of a results folder that state a probability."""
    store = ResultsStore(folder)
    table = with_numpy_types(store.table())
    maps = table[(table["kind"] == "matching") & table["probability"].notna()]
    maker = PairMaker(store)
    for _, rows in maps.groupby(PAIR, sort=False):
        for each in maker.read(rows).maps:
            sure = [each.found.confidence >= least for least in CONFIDENT]
            right = each.errors < 100 * RIGHT
            yield Judged(
                str(each.row["regime"]),
                float(each.row["probability"]),
                float(each.row["right_limb"]),
                tuple(int(some.sum()) for some in sure),
                tuple(int((some & right).sum()) for some in sure),
                len(right),
            )


def table_of(maps: list[Judged], apart: list[str]) -> str:
    """The table in Markdown; regimes that are apart come last."""
    lines = [
        "| regime | probability | maps | limbs right | at .5 | of them right | at .9 | of them right |",
        "|---|---|---|---|---|---|---|---|",
    ]
    others = "others" if apart else "all"
    for group in [others, *apart]:
        mine = [m for m in maps if group == next((text for text in apart if text in m.regime), others)]
        for words, (low, high) in RANGES.items():
            some = [m for m in mine if low <= m.probability < high]
            if some:
                lines.append(f"| {group} | {words} | {len(some)} | {' | '.join(cells(some))} |")
    return "\n".join(lines)


def cells(maps: list[Judged]) -> list[str]:
    """What is said of some maps, after their number."""
    points = sum(m.points for m in maps)
    found = [str(sum(m.right_limb >= LIMBS for m in maps))]
    for k in range(len(CONFIDENT)):
        sure, right = sum(m.confident[k] for m in maps), sum(m.right[k] for m in maps)
        found += [f"{100 * sure / points:.1f} %", f"{100 * right / sure:.1f} %" if sure else "-"]
    return found


def main() -> None:
    """Read the folders and print the table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("results", nargs="+", type=Path)
    parser.add_argument("--apart", action="append", default=[], metavar="TEXT")
    given = parser.parse_args()
    try:
        maps = [each for folder in given.results for each in judged(folder)]
    except InputError as error:
        parser.exit(2, f"{error}\n")
    sys.stdout.write(table_of(maps, given.apart) + "\n")


if __name__ == "__main__":
    main()
