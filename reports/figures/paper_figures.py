"""The figures of the paper by their numbers: which module makes each, and writing what it makes."""

from dataclasses import dataclass
from importlib import import_module
from pathlib import Path

from datasets_gen.records import InputError
from evaluation.results.origin import Origin, write_csv
from reports.figures.figure_request import FigureRequest, MadeFigure
from reports.figures.style import save


@dataclass(frozen=True)
class PaperFigure:
    """A figure of the paper.

    Attributes
    ----------
    name : str
        Of its module and of the function in it.
    about : str
        What it shows, in a line.
    """

    name: str
    about: str


FIGURES: dict[int, PaperFigure] = {
    1: PaperFigure("opposed_scans", "landmarks and dense map of scans from opposed sides"),
    2: PaperFigure("similarity_against_distance", "distance between medial points against medial similarity"),
    3: PaperFigure("dual_area_construction", "how the dual area of a point is found"),
    4: PaperFigure("diffusion_over_time", "medial diffusion over time, and its profile along a body"),
    5: PaperFigure("signature_at_times", "the signature at several times, across poses and missing data"),
    6: PaperFigure("error_over_threshold", "Eq. 18 against threshold and pose, with the clouds"),
    7: PaperFigure("symmetric_regions", "intrinsic symmetries between medial centres"),
    8: PaperFigure("human_matches", "landmarks and dense maps between scans of a human"),
    9: PaperFigure("quadruped_matches", "a match of quadrupeds, and the change of the signature"),
    10: PaperFigure("skeleton_comparison", "against matching of curve skeletons"),
    11: PaperFigure("heat_kernel_comparison", "against heat kernel matching"),
}


def make_figure(request: FigureRequest) -> MadeFigure:
    """Make a figure of the paper.

    Parameters
    ----------
    request

    Raises
    ------
    InputError
        If there is no such figure, or the data set lacks what it needs.
    """
    if request.number not in FIGURES:
        raise InputError(f"no figure {request.number!r}; the paper has {min(FIGURES)} to {max(FIGURES)}")
    entry = FIGURES[request.number]
    made = getattr(import_module(f"reports.figures.{entry.name}"), entry.name)(request)
    assert isinstance(made, MadeFigure)
    return made


def write_figure(number: int, made: MadeFigure, folder: Path) -> list[Path]:
    """Write a figure as PDF and PNG, and the numbers behind it as CSV.

    Parameters
    ----------
    number
        In the paper.
    made
    folder
        Files there of the same name are replaced.

    Returns
    -------
    list of Path
    """
    name = f"figure-{number}-{FIGURES[number].name.replace('_', '-')}"
    paths = save(made.figure, folder, name)
    table = folder / f"{name}.csv"
    write_csv(made.table, table, Origin.of(f"figure {number}", made.settings))
    return [*paths, table]
