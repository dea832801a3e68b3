"""``medialbench datasets``: list the built-in shapes, or write them as files."""

from pathlib import Path

import click

from reports.cli.console import Command, result_console, say
from reports.cli.progress import ProgressBar


@click.command(cls=Command, short_help="List the built-in shapes, or write them as files.")
@click.argument("name", required=False)
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), help="Folder to write PLY files and a manifest to."
)
@click.option("--seed", default=0, show_default=True, help="Proportions of a built-in body.")
def datasets(name: str | None, out: Path | None, seed: int, quiet: bool) -> None:
    """List the built-in data sets, or show one; with -o, write it as PLY files and a manifest.

    NAME is a built-in data set or a folder with one mesh per pose (ply, obj or off, shared connectivity).
    """
    from datasets_gen import load, names
    from reports.cli.output_paths import check_output_folder

    if name is None:
        if out is not None:
            raise click.UsageError(f"-o needs the NAME of a data set: {', '.join(names())}")
        _list(names(), quiet)
        return
    if out is not None:
        check_output_folder(out, () if name in names() else (name,))
    with ProgressBar(1, f"loading {name}", quiet) as bar:
        collection = load(name, **({"seed": seed} if name in names() else {}))
        bar.advance()
    if out is None:
        for shape in collection.shapes:
            result_console().print(shape.name, markup=False)
        say(quiet, _summary(collection.reference))
        return
    from datasets_gen import write_collection

    manifest = write_collection(collection, out, {"seed": seed} if name in names() else None)
    say(quiet, f"{len(collection.shapes)} poses and {manifest.name} written to {out}")


def _list(names: tuple[str, ...], quiet: bool) -> None:
    from datasets_gen import load

    rows = []
    with ProgressBar(len(names), "loading", quiet) as bar:
        for name in names:
            bar.describe(f"loading {name}")
            rows.append((name, load(name)))
            bar.advance()
    for name, collection in rows:
        poses = ", ".join(shape.pose for shape in collection.shapes)
        result_console().print(f"[bold]{name}[/]  {_summary(collection.reference)}\n    {poses}")


def _summary(shape: "object") -> str:
    vertices, faces = len(shape.vertices), len(shape.faces)  # type: ignore[attr-defined]
    return f"{vertices:,} vertices, {faces:,} faces, rest pose {shape.pose!r}"  # type: ignore[attr-defined]
