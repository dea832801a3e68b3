"""``medialbench compare``: the leaderboard of a results folder, and whether differences mean anything."""

from pathlib import Path

import click

from reports.cli.console import Command, Failure, print_lines, result_console
from reports.cli.results_folders import open_results

MEASURES = ("geodesic_mean", "geodesic_median", "geodesic_symmetric_mean", "medial_mean")


@click.command(cls=Command, short_help="Leaderboard of a results folder, with paired tests.")
@click.argument("folder", metavar="DIR", type=click.Path(path_type=Path))
@click.option(
    "--measure",
    type=click.Choice(MEASURES),
    default=MEASURES[0],
    show_default=True,
    help="What the tests compare.",
)
def compare(folder: Path, measure: str, quiet: bool) -> None:
    """Show the leaderboard of the results in DIR with its spread over seeds, and paired tests of the methods.

    The unit of the tests is the pair of poses: maps under other regimes or seeds of the same pair are no
    independent evidence. Intervals are by a hierarchical bootstrap, p-values by two-sided Wilcoxon
    signed-rank tests, corrected for their number (Holm).
    """
    from reports.tables.completeness import unmatched
    from reports.tables.leaderboard import ceilings, leaderboard, with_numpy_types
    from reports.tables.statistics import paired_tests
    from reports.tables.terminal import leaderboard_lines, tests_lines

    store = open_results(folder, "compare")
    table = with_numpy_types(store.table())
    board = leaderboard(table, ceilings(store.settings))
    if board.empty:
        raise Failure(
            f"{str(folder)!r} holds no correspondences to compare; run an experiment with [matching]"
        )
    print_lines(leaderboard_lines(board, result_console().width))
    tests, left_out = paired_tests(table, measure), unmatched(table[table["kind"] == "matching"])
    if len(tests) or left_out:
        result_console().print()
        print_lines(tests_lines(tests, measure, left_out))
