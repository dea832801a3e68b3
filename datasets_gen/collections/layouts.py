"""Data on disk: data sets of the field recognised by what is in a folder, a plain folder of poses last."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from datasets_gen.collection import Collection
from datasets_gen.collections import (
    fragments,
    frame_sequence,
    gltf,
    remeshed,
    shared_faces,
    shrec_partial,
    tosca,
)
from datasets_gen.collections.folder import load_folder, outline_folder, read_manifest
from datasets_gen.collections.gltf_buffers import GLTF_SUFFIXES


@dataclass(frozen=True)
class Layout:
    """A way in which a data set lies in a folder.

    Attributes
    ----------
    name : str
    about : str
        One line for people: what is in the folder.
    recognises : callable
        Whether a folder, or for glTF a file (Path), is one.
    load, outline : callable
        Of ``(path, *, options)``, as those of `datasets_gen.registry.Source`.
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
        "https://www.dais.unive.it/~shrec2016/dataset.php",
        "made of TOSCA's shapes; see its page",
        ("null", "cuts", "holes"),
    ),
    Layout(
        "remeshed sets",
        "SCAPE_r, FAUST_r, TOSCA_r: meshes (in off/ or not) + corres/*.vts; option subject",
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
        "with an account there; its licence forbids commercial use",
        ("training/registrations", "registrations"),
    ),
    Layout(
        "SCAPE",
        "mesh000.ply to mesh071.ply, or .off; option split",
        shared_faces.recognises_scape,
        shared_faces.load_scape,
        shared_faces.outline_scape,
        "https://ai.stanford.edu/~drago/Projects/scape/scape.html",
        "see its page",
    ),
    Layout(
        "TOSCA",
        "cat0.mat, or cat0.vert + cat0.tri, or cat0.off; option subject",
        tosca.recognises,
        tosca.load,
        tosca.outline,
        "http://tosca.cs.technion.ac.il/book/resources_data.html",
        "see its page",
    ),
    Layout(
        "frames of a capture",
        "frame_000.obj, frame_001.obj, ..., each with its own faces: no ground truth, for match alone",
        frame_sequence.recognises,
        frame_sequence.load,
        frame_sequence.outline,
        "https://people.csail.mit.edu/drdaniel/mesh_animation and others",
        "see the page of the capture",
    ),
)
"""In the order in which they are tried. Nothing is downloaded."""

GLTF = Layout(
    "glTF",
    "character.glb or .gltf with a skin and animations; options animations, frames",
    lambda path: path.suffix.lower() in GLTF_SUFFIXES,
    gltf.load,
    gltf.outline,
    "a character exported by a modelling program",
    "as its author says",
)
"""The one layout that is a file."""

POSES = Layout(
    "folder of poses",
    "one mesh per pose, all with the same faces",
    Path.is_dir,
    load_folder,
    outline_folder,
)


def is_data(path: Path) -> bool:
    """Whether there is something at a path that a layout may load: a folder, or a glTF file."""
    return path.is_dir() or (path.is_file() and GLTF.recognises(path))


def layout_of(path: Path) -> Layout:
    """The first layout that fits a folder, `POSES` if none does or it has our manifest; `GLTF` for a file."""
    if not path.is_dir():
        return GLTF
    if read_manifest(path):
        return POSES
    return next((layout for layout in LAYOUTS if layout.recognises(path)), POSES)


def files_read(path: Path) -> list[Path]:
    """All files that decide what is loaded from a path: in a folder, and in the folders of its layout."""
    if not path.is_dir():
        return gltf.files_of_gltf(path)
    places = [path, *(path / each for each in layout_of(path).subfolders)]
    return [file for place in places if place.is_dir() for file in place.iterdir() if file.is_file()]
