"""Which methods of a group can be ranked: those that answered everything that the others did.

A mean over fewer maps, or over maps that leave points out, is not the mean of the others. docs/methods.md
says what a point without a match costs.
"""

import pandas as pd

COMPLETE = 0.99
"""Share of points with a match from which maps count as complete."""
PAIR = ("dataset", "regime", "source_pose", "target_pose", "seed")
"""What makes a map one of those that every method should have."""


def unranked(maps: pd.DataFrame) -> dict[str, str]:
    """Why methods cannot be ranked among the others.

    Parameters
    ----------
    maps
        Rows of the results table with maps, of all methods that are compared.

    Returns
    -------
    dict of str to str
        A few words by method; only methods that cannot be ranked.
    """
    found = unmatched(maps)
    keys = [name for name in PAIR if name in maps]
    wanted = len(maps[keys].drop_duplicates())
    for method, rows in maps.groupby("method", sort=False):
        lacking = wanted - len(rows[keys].drop_duplicates())
        if lacking:
            words = [found[str(method)]] if str(method) in found else []
            found[str(method)] = "; ".join([*words, f"lacks {lacking} of {wanted} maps"])
    return found


def unmatched(maps: pd.DataFrame) -> dict[str, str]:
    """Methods that leave points out in some data set and regime, and how many they match there at worst.

    Tables of earlier versions do not say; their methods count as complete.
    """
    if "matched" not in maps:
        return {}
    keys = [name for name in (*PAIR[:2], "method") if name in maps]
    shares = pd.to_numeric(maps["matched"], errors="coerce").groupby([maps[key] for key in keys]).mean()
    worst = shares.groupby("method", sort=False).min()
    return {
        str(method): f"matches {100 * share:.{0 if share < 0.985 else 1}f} % of the points"
        for method, share in worst.items()
        if share < COMPLETE
    }
