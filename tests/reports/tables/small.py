"""Small tables: with ties, gaps and characters that need care; of scans that share little surface."""

import numpy as np
import pandas as pd

from evaluation.results.origin import Origin
from reports.tables.columns import Column

COLUMNS = (Column("name", "name & co"), Column("low", "low_1", 1, "low"), Column("high", "±", 2, "high"))
ORIGIN = Origin("1.2.3", "a_b & 50 %", "0123456789abcdef")
SMALL = pd.DataFrame(
    {
        "g": ["x", "x", "x", "y", "y"],
        "name": ["a|b", "50 % #1", "c", "d", "e"],
        "low": [1.04, 1.0, 2.0, np.nan, 3.0],
        "high": [0.5, 0.9, 0.1, 0.7, 0.7],
    }
)


def partial(table):
    """The table of `results`, as if scans shared little surface at the higher threshold."""
    scored = (table["kind"] == "matching").to_numpy()
    error = table["geodesic_mean"].to_numpy(float)
    values = {
        "overlap": np.where(table["source_threshold"].to_numpy(float) > 0.5, 0.3, 1.0),
        "oracle_mean": 2.0,
        "excess_mean": error - 2,
        "gross": error > 9,
        "right_limb": 0.8,
        "mirror_limb": 0.25,
        "medial_path_mean": 4.0,
        "sure_right": 0.995,
        "geodesic_best": error - 1,
        "alternatives": 2.0,
        "probability": 0.75,
    }
    return table.assign(**{k: np.where(scored, v, np.nan) for k, v in values.items()})
