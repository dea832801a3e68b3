"""Shapes with ground truth: built-in bodies, generated bodies and folders of posed meshes.

Read `shape` and `collection` first, then `registry`, which finds a collection by its name, then the folders:
``clouds`` (files of any format), ``meshes`` (geometry, remeshing, mirror maps), ``bodies`` (the built-in
ones), ``collections`` (one file per source) and ``points`` (what every package needs of a bare cloud).
`checks` refuses meshes that cannot be scanned. `records`, `cache`, `fingerprints` and `compiled` serve all
packages.

Checks, messages and file formats may be extended. A change in ``bodies``, ``meshes.remeshing`` or
``points`` changes built-in shapes, scans or maps.
"""

from datasets_gen.checks import check_mesh
from datasets_gen.collection import Collection
from datasets_gen.collections.folder import load_folder, write_collection
from datasets_gen.meshes.conversion import as_shape
from datasets_gen.meshes.files import MESH_SUFFIXES, load_mesh, write_mesh
from datasets_gen.meshes.mirroring import mirror_map
from datasets_gen.records import InputError
from datasets_gen.registry import load, names, provenance
from datasets_gen.shape import Shape

__all__ = [
    "MESH_SUFFIXES",
    "Collection",
    "InputError",
    "Shape",
    "as_shape",
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
