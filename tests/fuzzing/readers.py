"""What a target does with the file of a case; the readers of the project, as its commands call them."""

from contextlib import suppress
from pathlib import Path
from typing import Any

from datasets_gen import Collection, InputError, Shape, load_mesh
from datasets_gen.collections import gltf
from datasets_gen.collections.folder import load_folder, write_collection
from datasets_gen.collections.layouts import layout_of
from datasets_gen.meshes.colours import read_colours
from evaluation import ResultsStore
from medial.outward import estimate_normals
from reports.cli.cloud_files import read_cloud
from scanner_sim import Scan, ScannerConfig
from tests.datasets_gen.collections.layout_files import egg, write_off, write_table
from tests.fuzzing import seeds


def read_mesh(path: Path) -> Shape:
    """A mesh for the scanner; its strict and repaired forms and its colours may be refused."""
    with suppress(InputError):
        load_mesh(path, repair=True)
    with suppress(InputError):
        read_colours(path)
    return load_mesh(path, strict=False)


def compile_normals(_folder: Path) -> None:
    """Estimate normals once: compiling that takes longer than any reader may."""
    estimate_normals(seeds.cloud().points)


def read_points(path: Path) -> Scan:
    return read_cloud(path, 20)


def read_folder(path: Path) -> Collection:
    """A folder of poses, written again beside it."""
    found = load_folder(path.parent)
    write_collection(found, path.parent / "again")
    return found


def read_character(path: Path) -> Collection:
    """A character in two frames of each of its animations."""
    return gltf.load(path, frames=2)


def read_layout(path: Path) -> Collection:
    """The folder of the case, whose layout is found from its files."""
    return layout_of(path.parent).load(path.parent)


def write_tosca(folder: Path) -> None:
    """Another pose, as a MATLAB file."""
    (folder / "cat0.mat").write_bytes(seeds.tosca())


def write_vert(folder: Path) -> None:
    """Two poses of text files; the one of the case lacks nothing but its vertices."""
    (folder / "cat0.vert").write_bytes(seeds.vert())
    for pose in (0, 1):
        write_table(folder / f"cat{pose}.tri", seeds.shape().faces + 1)


def write_frame(folder: Path) -> None:
    """Another frame of a capture, with faces of its own."""
    write_off(folder / "frame_0.off", *egg())


def read_options(path: Path) -> dict[str, Any]:
    """NAME=VALUE lines, taken by a scanner or, after ``as=method``, by a method."""
    from reports.cli.set_options import merged

    settings = tuple(path.read_bytes().decode("utf-8", "replace").split("\n"))
    table = merged({"noise": None}, settings)
    if table.pop("as", "") == "method":
        from evaluation.methods import create

        create(str(table.pop("name", "medial")), table)
    else:
        ScannerConfig.from_dict(table)
    return table


def read_leaderboard(path: Path) -> Any:
    """What ``medialbench compare`` shows."""
    from reports.tables.leaderboard import ceilings, leaderboard, with_numpy_types

    store = ResultsStore(path.parent)
    return leaderboard(with_numpy_types(store.table()), ceilings(store.settings))


def read_notes(path: Path) -> Any:
    store = ResultsStore(path.parent)
    return store.run_info(), store.failures()


def read_score(path: Path) -> Any:
    return ResultsStore(path.parent.parent).score("some")


def write_store(folder: Path) -> None:
    """A results folder around the file of the case."""
    for name, content in seeds.results_files().items():
        (folder / name).parent.mkdir(exist_ok=True)
        (folder / name).write_bytes(content)
