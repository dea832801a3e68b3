import re

import pytest

from evaluation.results.store import ResultsStore
from reports.tables.leaderboard import leaderboard, with_numpy_types
from reports.tables.terminal import leaderboard_lines
from tests.reports.tables.small import partial


@pytest.mark.parametrize("width", [80, 120])
def test_excess_and_limbs_are_shown_where_scans_share_little_and_still_fit(results, width):
    table = with_numpy_types(ResultsStore(results).table())
    for shared_little in (False, True):
        board = leaderboard(partial(table) if shared_little else table)
        board["method"] = board["method"].replace("medial diffusion", "tufted Laplacian (paper)")
        lines = [re.sub(r"\[/?[a-z]*\]", "", line) for line in leaderboard_lines(board, width)]
        assert max(map(len, lines)) <= width
        heads = " ".join(lines[:2])
        assert ("excess" in heads) == ("right" in heads) == shared_little
        assert ("least" in heads) == (shared_little and width == 120)
