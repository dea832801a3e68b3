"""Folders of meshes: data sets of the field recognised by what is in them, a plain folder of poses last."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from datasets_gen.collection import Collection
from datasets_gen.collections import fragments, remeshed, shared_faces, shrec_partial, tosca
from datasets_gen.collections.folder import load_folder, outline_folder, read_manifest


@dataclass(frozen=True)
class Layout:
    """A way in which a data set lies in a folder.

    Attributes
    ----------
    name : str
    about : str
        One line for people: what is in the folder.
    recognises : callable
        Whether a folder (Path) is one.
    load, outline : callable
        Of ``(folder, *, options)``, as those of `datasets_gen.registry.Source`.
    origin : str
        Where it comes from.
    terms : str
        Under which it may be used.
    subfolders : tuple of str
        Where files are read beside the folder itself.
    """

    name: str
    about: str
    recognises: Callable[[Path], bool]
    load: Callable[..., Collection]
    outline: Callable[..., dict[str, Any]]
    origin: str = ""
    terms: str = ""
    subfolders: tuple[str, ...] = ()


LAYOUTS = (
    Layout(
        "SHREC'16 Partial",
        "null/cat.off, cuts/cuts_cat_shape_1.off + .baryc_gt, holes/; options subject, kind",
        shrec_partial.recognises,
        shrec_partial.load,
        shrec_partial.outline,
        "https://www.dais.unive.it/~shrec2016",
        "for research; the shapes are made of TOSCA",
        ("null", "cuts", "holes"),
    ),
    Layout(
        "remeshed sets",
        "SCAPE_r, FAUST_r, TOSCA_r: off/ + corres/*.vts; option subject",
        remeshed.recognises,
        remeshed.load,
        remeshed.outline,
        "https://github.com/llorz/SGA18_orientation_BCICP_dataset",
        "those of the set that was remeshed",
        ("off", "corres"),
    ),
    Layout(
        "PFARM, CP2P",
        "shapes/*.off + maps/A_B.map, from 0, or .corr; option reference",
        fragments.recognises,
        fragments.load,
        fragments.outline,
        "https://github.com/pvnieo/cp2p-pfarm-benchmark",
        "those of the sets that they are made of",
        ("shapes", "maps"),
    ),
    Layout(
        "FAUST",
        "training/registrations/tr_reg_000.ply; options split, people",
        shared_faces.recognises_faust,
        shared_faces.load_faust,
        shared_faces.outline_faust,
        "https://faust-leaderboard.is.tuebingen.mpg.de",
        "registration; research only",
        ("training/registrations", "registrations"),
    ),
    Layout(
        "SCAPE",
        "mesh000.ply to mesh071.ply, or .off; option split",
        shared_faces.recognises_scape,
        shared_faces.load_scape,
        shared_faces.outline_scape,
        "https://ai.stanford.edu/~drago/Projects/scape/scape.html",
        "from its authors on request; research only",
    ),
    Layout(
        "TOSCA",
        "cat0.mat, or cat0.vert + cat0.tri, or cat0.off; option subject",
        tosca.recognises,
        tosca.load,
        tosca.outline,
        "http://tosca.cs.technion.ac.il",
        "research, as its page says",
    ),
)
"""In the order in which they are tried. Nothing is downloaded."""

POSES = Layout(
    "folder of poses",
    "one mesh per pose, all with the same faces",
    Path.is_dir,
    load_folder,
    outline_folder,
)


def layout_of(folder: Path) -> Layout:
    """The first layout that recognises a folder; `POSES` if it has our manifest, or none does."""
    if read_manifest(folder):
        return POSES
    return next((layout for layout in LAYOUTS if layout.recognises(folder)), POSES)


def files_read(folder: Path) -> list[Path]:
    """All files that decide what is loaded from a folder: its own, and those in the folders of its layout."""
    places = [folder, *(folder / each for each in layout_of(folder).subfolders)]
    return [path for place in places if place.is_dir() for path in place.iterdir() if path.is_file()]
