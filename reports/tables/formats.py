"""Tables as Markdown, LaTeX and CSV."""

import os
import re
from collections.abc import Callable, Sequence
from pathlib import Path

import pandas as pd

from datasets_gen.records import atomic_path
from evaluation.results.origin import Origin, write_csv
from evaluation.results.outcome import printable
from reports.tables.columns import Column, best_cells, cell_text, filled_columns


def to_markdown(table: pd.DataFrame, columns: Sequence[Column], group: Sequence[str]) -> str:
    """A Markdown table, the best of each group in bold."""
    head = [column.title for column in columns]
    rule = ["---" if column.digits is None else "---:" for column in columns]
    body = _cells(table, columns, group, lambda cell: f"**{cell}**", _markdown)
    return "\n".join("| " + " | ".join(row) + " |" for row in [head, rule, *body]) + "\n"


def to_latex(table: pd.DataFrame, columns: Sequence[Column], group: Sequence[str]) -> str:
    """A LaTeX table (package booktabs), the best of each group in bold, a rule between groups."""
    align = "".join("l" if column.digits is None else "r" for column in columns)
    head = " & ".join(_tex(column.title) for column in columns) + r" \\"
    body = _cells(table, columns, group, lambda cell: rf"\textbf{{{cell}}}", _tex)
    lines = []
    keys = list(table[list(group)].itertuples(index=False, name=None))
    for i, row in enumerate(body):
        if i and keys[i] != keys[i - 1]:
            lines.append(r"\midrule")
        lines.append(" & ".join(row) + r" \\")
    parts = [
        rf"\begin{{tabular}}{{{align}}}",
        r"\toprule",
        head,
        r"\midrule",
        *lines,
        r"\bottomrule",
        r"\end{tabular}",
    ]
    return "\n".join(parts) + "\n"


def _cells(
    table: pd.DataFrame,
    columns: Sequence[Column],
    group: Sequence[str],
    bold: Callable[[str], str],
    escape: Callable[[str], str],
) -> list[list[str]]:
    best = best_cells(table, columns, group)
    rows = []
    for i, row in table.iterrows():
        cells = {c.name: escape(cell_text(row[c.name], c)) for c in columns}
        rows.append([bold(cells[c.name]) if (i, c.name) in best else cells[c.name] for c in columns])
    return rows


def _markdown(value: str) -> str:
    """Text that is shown as it is, also with HTML allowed."""
    return re.sub(r"[\\`*_\[\]<>|~]", r"\\\g<0>", value.replace("&", "&amp;"))


_TEX = {
    "\\": r"\textbackslash{}",
    "τ": r"$\tau$",
    "±": r"$\pm$",
    "–": "--",
    "×": r"$\times$",
    "√": r"$\surd$",
    "→": r"$\to$",
}
_TEX |= {c: "\\" + c for c in "&%$#_{}"} | {"~": r"\textasciitilde{}", "^": r"\textasciicircum{}"}
_TEX |= {"<": r"\textless{}", ">": r"\textgreater{}", "|": r"\textbar{}", "`": r"\textasciigrave{}"}
_TEX |= {c: f"{{{c}}}" for c in "[]*"}  # at the beginning of a row they would belong to the \\ before
_JOINED = re.compile(r"(?<=([-'<>,]))\1")
"""Characters that LaTeX joins into another one when they stand side by side."""


def _tex(value: str) -> str:
    parts = [_TEX.get(character, character) for character in value]
    for match in _JOINED.finditer(value):
        parts[match.start()] = "{}" + parts[match.start()]
    return "".join(parts)


def write_table(
    table: pd.DataFrame,
    columns: Sequence[Column],
    group: Sequence[str],
    folder: str | os.PathLike[str],
    name: str,
    origin: Origin,
) -> dict[str, Path]:
    """Write ``name.md``, ``name.tex`` and ``name.csv``, each with its origin; return the paths by suffix."""
    shown = filled_columns(columns, table)
    paths = {suffix: Path(folder) / f"{name}.{suffix}" for suffix in ("md", "tex", "csv")}
    line = printable(origin.line)
    texts = {
        "md": to_markdown(table, shown, group) + (f"\n{_markdown(line)}\n" if line else ""),
        "tex": (f"% {line}\n" if line else "") + to_latex(table, shown, group),
    }
    for suffix, content in texts.items():
        with atomic_path(paths[suffix]) as temporary:
            temporary.write_text(content, encoding="utf-8")
    write_csv(table[[column.name for column in shown]], paths["csv"], origin)
    return paths
