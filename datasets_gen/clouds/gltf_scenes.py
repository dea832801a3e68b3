"""Meshes and points of a glTF file, ``.glb`` or ``.gltf``, as they stand in its scene."""

from pathlib import Path
from typing import Any

import numpy as np

from datasets_gen.clouds.point_cloud import PointCloud
from datasets_gen.clouds.stl_surfaces import welded
from datasets_gen.paths import inside


def read_gltf(file: Path) -> PointCloud:
    """Read a glTF file: all meshes where its nodes put them, as one.

    Corners at seams of texture and normals are welded. Skins and animations are left out: what stands in the
    file is the bind pose.

    Raises
    ------
    ValueError
        If there is nothing in it, or the file is damaged. trimesh raises anything else on a damaged file.
    """
    import trimesh  # where it is needed: a start without it takes half as long

    class Beside(trimesh.resolvers.Resolver):
        """Buffers in the folder of the file, and nowhere else."""

        def __init__(self) -> None:
            """Know the folder by `file`."""

        def get(self, name: str) -> bytes:
            place = inside(file.parent, name, f"buffer of {file.name!r},")
            if not place.is_file():
                raise ValueError(f"the buffer {name!r} is missing; put it beside the file")
            return place.read_bytes()

        def get_base(self) -> str:
            return ""

        def namespaced(self, namespace: str) -> "Beside":
            return self

        def keys(self) -> list[str]:
            return []

        def write(self, name: str, data: Any) -> None:
            raise ValueError("a file that is read is not written")

    content = file.read_bytes()
    with file.open("rb") as stream:
        scene: Any = trimesh.load_scene(
            stream, file_type=file.suffix.lower()[1:], resolver=Beside(), process=False, skip_materials=True
        )
    placed = scene.dump()
    meshes = [each for each in placed if isinstance(each, trimesh.Trimesh) and len(each.faces)]
    skinned = "a skin or animation is left out: the bind pose" if b'"skins"' in content else ""
    if not meshes:
        clouds = [each for each in placed if isinstance(each, trimesh.PointCloud)]
        if not clouds:
            raise ValueError("neither meshes nor points in its scene")
        points = np.concatenate([np.asarray(each.vertices, dtype=np.float64) for each in clouds])
        return PointCloud(points).remarked(skinned)
    offsets = np.cumsum([0, *(len(each.vertices) for each in meshes)])
    vertices = np.concatenate([np.asarray(each.vertices, dtype=np.float64) for each in meshes])
    faces = [np.asarray(m.faces, dtype=np.int64) + k for m, k in zip(meshes, offsets[:-1], strict=True)]
    ids = np.concatenate(faces)
    if ids.min() < 0 or ids.max() >= len(vertices) or not np.isfinite(vertices).all():
        raise ValueError("faces name vertices that are not there, or vertices are not finite")
    several = f"{len(meshes)} meshes of the scene are one" if len(meshes) > 1 else ""
    return welded(vertices, "glTF repeats vertices at seams", ids).remarked(several, skinned)
