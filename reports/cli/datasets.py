"""``medialbench datasets``: list the shapes there are, look at one collection, or write it as files."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from reports.cli.console import Command, print_lines, say
from reports.cli.progress import ProgressBar
from reports.cli.set_options import merged

if TYPE_CHECKING:
    from datasets_gen import Collection

SHEET_DPI = 110


@click.command(cls=Command, short_help="List the built-in shapes, or write them as files.")
@click.argument("name", required=False)
@click.option(
    "-o", "--out", type=click.Path(path_type=Path), help="Folder to write PLY files and a manifest to."
)
@click.option(
    "--picture",
    type=click.Path(path_type=Path),
    help="Draw all poses to this .png; without NAME, of all bodies.",
)
@click.option("--seed", type=int, help="Proportions of a built-in body; 0 is the default one.")
@click.option(
    "--set", "settings", multiple=True, metavar="NAME=VALUE",
    help="Further option, such as subjects=3, variation=0.1, mesh_noise=0.2 or poses=[\"walk\"].",
)  # fmt: skip
def datasets(
    name: str | None,
    out: Path | None,
    picture: Path | None,
    seed: int | None,
    settings: tuple[str, ...],
    quiet: bool,
) -> None:
    """List the data sets that have a name, or show one; with -o, write it as PLY files and a manifest.

    NAME is one of them, a folder with one mesh per pose (ply, obj or off, shared connectivity), the folder
    of a data set of the field as it comes (TOSCA, SHREC'16 Partial, ...; the list has them), or a glTF
    character. Shown of a pose is how far the lengths of its edges are from those of the rest pose, then the
    report of loading: pieces, holes, winding, units, duplicates, and what was changed.
    """
    from datasets_gen import names
    from datasets_gen.bodies.built_in import BODIES
    from reports.cli.output_paths import check_output_file, check_output_folder

    options = merged({"seed": seed}, settings)
    if name is None and (out is not None or options):
        raise click.UsageError(f"-o, --seed and --set need the NAME of a data set: {', '.join(names())}")
    if picture is not None:
        check_output_file(picture, (".png",))
    if out is not None:
        check_output_folder(out, () if name in names() else (str(name),))
    if name is None and picture is None:
        _list(quiet)
        return
    loaded = _loaded([name] if name else [*BODIES], options, quiet)
    if picture is not None:
        _draw(loaded, picture)
        say(quiet, f"{sum(map(len, loaded))} poses drawn to {picture}")
    if out is not None:
        _write(str(name), loaded[0], out, options, quiet)
    if out is None and picture is None:
        _show(loaded[0], quiet)


def _loaded(names: list[str], options: dict[str, Any], quiet: bool) -> list["Collection"]:
    from datasets_gen import load

    found = []
    with ProgressBar(len(names), "loading", quiet) as bar:
        for name in names:
            bar.describe(f"loading {name}")
            found.append(load(name, **options))
            bar.advance()
    return found


def _draw(collections: list["Collection"], picture: Path) -> None:
    from reports.figures.pose_sheet import pose_sheet
    from reports.figures.style import save

    save(pose_sheet(collections), picture.parent, picture.stem, formats=(".png",), dpi=SHEET_DPI)


def _write(name: str, collection: "Collection", out: Path, options: dict[str, Any], quiet: bool) -> None:
    from datasets_gen import names, provenance, write_collection

    manifest = write_collection(collection, out, provenance(name, **options) if name in names() else None)
    say(quiet, f"{len(collection)} poses and {manifest.name} written to {out}")


def _list(quiet: bool) -> None:
    """A line for each collection that has a name, and its poses."""
    from rich.markup import escape

    from datasets_gen.collections.layouts import GLTF, LAYOUTS, POSES
    from datasets_gen.registry import HELD_OUT, SOURCES

    for name, source in SOURCES.items():
        kept = "; held out" if name in HELD_OUT else ""
        missing = source.missing
        print_lines([f"[bold]{name}[/]  {escape(source.about)} ({source.origin}, {source.licence}{kept})"])
        poses = f"not installed: {missing}" if missing else ", ".join(source.outline(name)["poses"])
        print_lines([f"    {escape(poses)}"])
    print_lines(["", "Of your own files, given by their path instead of a name; nothing is downloaded:"])
    for layout in (*LAYOUTS, GLTF, POSES):
        print_lines([f"[bold]{escape(layout.name)}[/]  {escape(layout.about)}"])
        if layout.origin:
            print_lines([f"    {escape(layout.origin)} (terms: {escape(layout.terms)})"])
    say(quiet, "held out: no constant of a method may be tuned on these; docs/bodies.md")


def _show(collection: "Collection", quiet: bool) -> None:
    from rich.markup import escape

    from datasets_gen.meshes.soundness import edge_stretch
    from evaluation.results.outcome import printable

    rest = collection.reference
    for shape in collection.shapes:
        own = f"{len(shape.vertices):,} vertices of its own"
        if not collection.truth:
            line = own
        elif shape.pose in collection.placements:
            line = f"{own}, placed on {rest.pose!r}"
        else:
            line = edge_stretch(shape, rest).line
        told = "" if quiet else f"  {line}"
        print_lines([escape(printable(shape.name) + told)])
    size = f"{len(rest.vertices):,} vertices, {len(rest.faces):,} faces"
    if collection.truth:
        say(quiet, f"{size}, rest pose {rest.pose!r}; edges against those of the rest pose")
    for remark in collection.remarks:
        say(quiet, printable(remark))
