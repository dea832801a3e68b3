"""A small table with ties, gaps and characters that need care."""

import numpy as np
import pandas as pd

from reports.tables.columns import Column

COLUMNS = (Column("name", "name & co"), Column("low", "low_1", 1, "low"), Column("high", "±", 2, "high"))
SMALL = pd.DataFrame(
    {
        "g": ["x", "x", "x", "y", "y"],
        "name": ["a|b", "50 % #1", "c", "d", "e"],
        "low": [1.04, 1.0, 2.0, np.nan, 3.0],
        "high": [0.5, 0.9, 0.1, 0.7, 0.7],
    }
)
