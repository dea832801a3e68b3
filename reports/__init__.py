"""Figures, tables and the report page; reads only the results store."""

from typing import Any

__all__ = ["build"]


def __getattr__(name: str) -> Any:
    """Import `build` when it is asked for: the command line must start without Matplotlib."""
    if name == "build":
        from reports.page.report import build

        return build
    raise AttributeError(f"module 'reports' has no attribute {name!r}")
