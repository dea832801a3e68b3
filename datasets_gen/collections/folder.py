"""Collections on disk: a folder with one mesh file per pose, and optionally a manifest."""

import contextlib
import json
import logging
import os
import shutil
from collections.abc import Mapping, Sequence
from dataclasses import replace
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Any

import numpy as np

from datasets_gen.checks import admitted
from datasets_gen.collection import Collection
from datasets_gen.collections.file_choice import natural, pose_list
from datasets_gen.collections.load_report import poses_report
from datasets_gen.meshes.files import MESH_SUFFIXES, read_mesh, write_mesh
from datasets_gen.meshes.mirroring import mirror_map
from datasets_gen.parsing import parsed_json
from datasets_gen.paths import distinct_names, inside
from datasets_gen.records import InputError, atomic_path
from datasets_gen.shape import Shape

_log = logging.getLogger(__name__)

MANIFEST = "manifest.json"
FORMAT = "medialbench-collection-1"
REST_NAMES = (
    "rest",
    "bind",
    "tpose",
    "t_pose",
    "t-pose",
    "apose",
    "a_pose",
    "a-pose",
    "neutral",
    "reference",
    "0",
)


def load_folder(
    folder: str | os.PathLike[str],
    *,
    reference: str | None = None,
    poses: Sequence[str] | None = None,
    repair: bool = False,
    units: str | None = None,
) -> Collection:
    """Load a folder of meshes with the same connectivity as the poses of one subject.

    Vertex i and face i must be the same surface element in every file: ground truth is the identity on
    face ids and barycentric coordinates. The left-right map is found from the reference pose
    (`datasets_gen.meshes.mirroring.mirror_map`).

    Parameters
    ----------
    folder
        Holds ``.ply``, ``.obj`` or ``.off`` files, one per pose, named by their stem. A ``manifest.json``
        as `write_collection` makes it decides files, subject, reference and units.
    reference
        The rest pose. Default: the manifest's, else a file named like a rest pose (``rest``, ``bind``,
        ``tpose``, ``neutral``, ``reference``, ``0``), else the first by name.
    poses
        Poses to load beside the reference, in this order. Default: all.
    repair
        Keep only the largest component and drop degenerate faces, in every pose alike.
    units
        Length unit. Default: the manifest's, else unknown.

    Raises
    ------
    InputError
        If the folder holds no meshes, a file cannot be used, or the files differ in their faces.
    """
    root = Path(folder)
    if not root.is_dir():
        raise InputError(f"{str(folder)!r} is not a folder; give a folder with one mesh file per pose")
    manifest = read_manifest(root)
    files = _pose_files(root, manifest)
    subject = str(manifest.get("subject") or root.resolve().name)
    rest = _reference_pose(files, reference, manifest, subject)
    wanted = list(files) if poses is None else pose_list(poses, files, subject)
    order = [rest, *(pose for pose in wanted if pose != rest)]
    length = units or str(manifest.get("units", "unknown"))
    shapes = [
        replace(read_mesh(files[pose], subject, length), name=f"{subject}/{pose}", pose=pose)
        for pose in order
    ]
    check_shared(shapes, files)
    for what, there in (("vertices", len(shapes[0].vertices)), ("faces", len(shapes[0].faces))):
        if manifest.get(what, there) != there:
            said = f"{str(root / MANIFEST)!r} says {manifest[what]!r} {what}, the files have {there}"
            raise InputError(f"{said}; correct or remove it")
    sound = admitted(shapes, repair)
    by_pose, remarks = dict(zip(order, sound, strict=True)), poses_report(shapes, sound)
    chosen, first = tuple(by_pose[p] for p in wanted), by_pose[rest]
    return Collection(subject, chosen, first, mirror_map(first), remarks=remarks)


def outline_folder(
    folder: str | os.PathLike[str],
    *,
    reference: str | None = None,
    poses: Sequence[str] | None = None,
    repair: bool = False,
    units: str | None = None,
) -> dict[str, Any]:
    """Subject, poses and reference that `load_folder` would give, from the names of the files alone.

    Parameters
    ----------
    folder, reference, poses, repair, units
        As for `load_folder`; the last two change nothing here.

    Returns
    -------
    dict
        ``subject`` (str), ``poses`` (list of str, in order), ``reference`` (str).

    Raises
    ------
    InputError
        If the folder holds no meshes, or lacks a pose that is asked for.
    """
    root = Path(folder)
    manifest = read_manifest(root)
    files = _pose_files(root, manifest)
    subject = str(manifest.get("subject") or root.resolve().name)
    return {
        "subject": subject,
        "poses": list(files) if poses is None else pose_list(poses, files, subject),
        "reference": _reference_pose(files, reference, manifest, subject),
    }


def write_collection(
    collection: Collection, folder: str | os.PathLike[str], about: dict[str, Any] | None = None
) -> Path:
    """Write every pose as ``.ply`` and, last, a manifest that `load_folder` reads back.

    Poses whose names are no file names are written under encoded ones (`datasets_gen.paths.safe_name`); the
    manifest has the names as they are.

    Parameters
    ----------
    collection
    folder
        Created if missing. Files of the same names are replaced.
    about
        Further entries of the manifest, such as licence or seed.

    Returns
    -------
    Path
        The manifest.

    Raises
    ------
    InputError
        If the folder cannot be written, or holds the poses of something else, or a pose has its own mesh.
    """
    if collection.placements or not collection.truth:
        pose = next(iter(collection.placements), collection.poses[-1])
        raise InputError(
            f"pose {pose!r} of {collection.subject!r} has a mesh of its own, which a folder of poses that "
            "share their faces cannot hold; keep the files it was loaded from, or use Collection.save"
        )
    root = Path(folder)
    shapes = {shape.pose: shape for shape in (collection.reference, *collection.shapes)}
    files = {pose: f"{name}.ply" for pose, name in distinct_names(list(shapes), "pose").items()}
    strangers = sorted(
        file.name for file in (root.iterdir() if root.is_dir() else ())
        if file.suffix.lower() in MESH_SUFFIXES and file.name not in files.values()
    )  # fmt: skip
    if strangers:
        raise InputError(f"{str(folder)!r} already holds {strangers[0]!r}; choose an empty folder")
    fresh, before = not root.exists(), {name for name in files.values() if (root / name).exists()}
    reference = collection.reference
    manifest = {
        "format": FORMAT,
        "subject": collection.subject,
        "units": reference.units,
        "reference": reference.pose,
        "vertices": len(reference.vertices),
        "faces": len(reference.faces),
        "poses": [{"pose": pose, "file": file} for pose, file in files.items()],
        "made_by": f"medialbench {code_version()}",
        **(about or {}),
    }
    try:
        for pose, shape in shapes.items():
            write_mesh(shape, root / files[pose])
        with atomic_path(root / MANIFEST) as temporary:
            temporary.write_text(json.dumps(manifest, indent=2) + "\n", encoding="utf-8")
    except BaseException:
        if fresh:  # a part of the poses would look like a data set
            shutil.rmtree(root, ignore_errors=True)
        for name in set(files.values()) - before:
            with contextlib.suppress(OSError):
                (root / name).unlink()
        raise
    return root / MANIFEST


def code_version() -> str:
    """Version of the installed distribution."""
    try:
        return version("medialbench")
    except PackageNotFoundError:
        return "unknown"


def read_manifest(root: Path) -> dict[str, Any]:
    """What `write_collection` noted in a folder; empty without a manifest, or with one of another format.

    Raises
    ------
    InputError
        If the manifest cannot be read.
    """
    path = root / MANIFEST
    if not path.is_file():
        return {}
    try:
        manifest = parsed_json(path.read_bytes(), repr(str(path)))
    except OSError as error:
        raise InputError(f"{str(path)!r} cannot be read: {error.strerror}; correct or remove it") from error
    if not isinstance(manifest, dict) or manifest.get("format") != FORMAT:
        _log.warning("%s is not a medialbench manifest (format %r); ignored", path, FORMAT)
        return {}
    return manifest


def _pose_files(root: Path, manifest: dict[str, Any]) -> dict[str, Path]:
    """Mesh file of each pose, in natural order of the names or in the manifest's order."""
    if manifest:
        try:
            named = [(entry["pose"], entry["file"]) for entry in manifest["poses"]]
            words = all(isinstance(each, str) and each for pair in named for each in pair)
        except (KeyError, TypeError):
            words = False
        if not words:
            raise InputError(f"{str(root / MANIFEST)!r} lacks 'poses' of 'pose' and 'file'; write it again")
        files = {pose: inside(root, file, f"file of pose {pose!r}") for pose, file in named}
        if len(files) < len(named):
            raise InputError(f"{str(root / MANIFEST)!r} names a pose twice; keep one of each")
    else:
        found = [file for file in root.iterdir() if file.suffix.lower() in MESH_SUFFIXES]
        found.sort(key=lambda file: natural(file.name))
        files = {file.stem: file for file in found}
        if len(files) < len(found):
            twice = next(f.name for f in found if files[f.stem] != f)
            raise InputError(f"{str(root)!r} has two files for the pose of {twice!r}; keep one")
    if not files:
        raise InputError(f"{str(root)!r} holds no mesh files ({', '.join(MESH_SUFFIXES)})")
    return files


def _reference_pose(files: dict[str, Path], asked: str | None, manifest: dict[str, Any], subject: str) -> str:
    pose = asked or manifest.get("reference")
    if pose is not None:
        if pose not in files:
            raise InputError(f"{subject!r} has no pose {pose!r} to be the reference; it has {list(files)}")
        return str(pose)
    for rest in REST_NAMES:
        for name in files:
            if name.lower() == rest or (rest == "0" and name.isdigit() and int(name) == 0):
                _log.info("%s: reference pose is %r, by its name", subject, name)
                return name
    first = next(iter(files))
    _log.warning("%s: reference pose is %r, the first by name; choose one with reference=", subject, first)
    return first


def check_shared(shapes: list[Shape], files: Mapping[str, Path]) -> None:
    """Raise InputError, with both files, unless shapes have the faces of the first."""
    rest = shapes[0]
    for shape in shapes[1:]:
        file, first = str(files[shape.pose]), files[rest.pose].name
        if shape.vertices.shape != rest.vertices.shape or shape.faces.shape != rest.faces.shape:
            raise InputError(
                f"{file!r} has {len(shape.vertices)} vertices and {len(shape.faces)} faces, "
                f"{first!r} has {len(rest.vertices)} and {len(rest.faces)}; poses must share them; "
                "`medialbench match` takes other meshes"
            )
        if not np.array_equal(shape.faces, rest.faces):
            raise InputError(
                f"{file!r} has other faces than {first!r}; poses must share them; "
                "`medialbench match` takes other meshes"
            )
