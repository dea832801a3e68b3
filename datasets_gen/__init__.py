"""Shapes with ground truth: built-in bodies, generated bodies and folders of posed meshes."""

from datasets_gen.checks import check_mesh
from datasets_gen.collections.folder import load_folder, write_collection
from datasets_gen.meshes.files import MESH_SUFFIXES, load_mesh, write_mesh
from datasets_gen.meshes.mirroring import mirror_map
from datasets_gen.records import InputError
from datasets_gen.registry import load, names, provenance
from datasets_gen.shape import Collection, Shape

__all__ = [
    "MESH_SUFFIXES",
    "Collection",
    "InputError",
    "Shape",
    "check_mesh",
    "load",
    "load_folder",
    "load_mesh",
    "mirror_map",
    "names",
    "provenance",
    "write_collection",
    "write_mesh",
]
