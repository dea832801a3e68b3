"""``medialbench merge``: results of several machines in one folder."""

from pathlib import Path

import click

from reports.cli.console import Command, result_console, say
from reports.cli.progress import ProgressBar


@click.command(cls=Command, short_help="Join the results of several machines.")
@click.argument("folders", metavar="DIR...", nargs=-1, required=True, type=click.Path(path_type=Path))
@click.option(
    "-o",
    "--out",
    type=click.Path(path_type=Path),
    help="New folder for the joint results.  [default: merged, beside the first DIR]",
)
def merge(folders: tuple[Path, ...], out: Path | None, quiet: bool) -> None:
    """Join results folders that share the work of one experiment by data set, method or seed.

    The joint folder stands by itself: medialbench report and compare read it, and medialbench run on its
    experiment.toml goes on with what is missing.
    """
    from reports.cli.output_paths import check_output_folder

    out = out or folders[0].resolve().parent / "merged"
    check_output_folder(out, folders)
    with ProgressBar(1, "merging", quiet) as bar:
        from datasets_gen.clouds.point_cloud import counted
        from evaluation.results.merging import merge_results

        store = merge_results(folders, out)
        bar.advance()
    say(quiet, f"{counted(len(store.table()), 'row')} from {counted(len(folders), 'folder')}")
    result_console().print(str(out), markup=False, soft_wrap=True)
