"""Figures, tables and the report page of a results folder, and the command line.

Read `cli` (what a user types), then `tables`, `figures` and `page`; `method_order` gives methods their order
and colours everywhere. `given_clouds`, `ground_truth` and `draw` serve the calls of `medialbench` on clouds.
Tables and page read only the results store; all but `given_clouds` may change without harm to results.
"""

from typing import Any

__all__ = ["build"]


def __getattr__(name: str) -> Any:
    """Import `build` when it is asked for: the command line must start without Matplotlib."""
    if name == "build":
        from reports.page.report import build

        return build
    raise AttributeError(f"module 'reports' has no attribute {name!r}")
