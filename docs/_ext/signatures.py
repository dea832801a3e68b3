"""Docstrings and signatures as they are written in this project.

Signatures show ``NDArray[np.float64]``, and no list of fields that follow one by one. ``|x|`` is a norm.
"""

import re
from dataclasses import fields, is_dataclass
from typing import Any

from docutils.parsers.rst.states import Inliner
from sphinx.application import Sphinx

ARRAY = re.compile(
    r"~?(?:numpy\.)?ndarray\[tuple\[~?(?:typing\.)?Any, \.\.\.\], ~?(?:numpy\.)?dtype\[([^\[\]]*)\]\]"
)
MOST_FIELDS = 12
"""A class with more of them has each documented below; its signature would only repeat them."""


def shortened(
    app: Sphinx, what: str, name: str, obj: Any, options: Any, signature: str | None, returned: str | None
) -> tuple[str | None, str | None]:
    """Signature and return type of an object, readable."""
    if what == "class" and is_dataclass(obj) and len(fields(obj)) > MOST_FIELDS:
        return "(*, ...)", returned
    short = [text and ARRAY.sub(r"NDArray[\1]", text) for text in (signature, returned)]
    return short[0], short[1]


def skipped(app: Sphinx, what: str, name: str, obj: Any, skip: bool, options: Any) -> bool | None:
    """Leave out fields of named tuples without a text of their own, and what Matplotlib adds."""
    foreign = str(getattr(obj, "__module__", "")).startswith("matplotlib")
    silent = str(getattr(obj, "__doc__", "")).startswith("Alias for field number")
    return True if foreign or silent else None


def bar(self: Inliner, match: re.Match[str], line: int) -> tuple[str, list[Any], str, list[Any]]:
    """Take a bar for a bar: reStructuredText would look for a substitution, of which there are none here."""
    end = match.end("start")
    return match.string[:end], [], match.string[end:], []


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the handlers."""
    Inliner.dispatch["|"] = bar
    app.connect("autodoc-process-signature", shortened)
    app.connect("autodoc-skip-member", skipped)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
