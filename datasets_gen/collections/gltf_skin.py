"""The surface of a glTF character: primitives of all its meshes joined, bound to joints, seams welded."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from datasets_gen.checks import repeated_corners
from datasets_gen.collections.gltf_buffers import GltfFile
from datasets_gen.collections.gltf_motion import Changes, world_matrices
from datasets_gen.collections.skinned import linear_blend_skinning
from datasets_gen.meshes.geometry import first_at_places
from datasets_gen.records import InputError

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

TRIANGLES, STRIP, FAN = 4, 5, 6
DIGITS = 6
"""Decimals to which the weights of two vertices have to agree to be welded."""


@dataclass(frozen=True)
class _Part:
    """A primitive: vertices (v, 3), faces (f, 3), movers and weights of vertices (v, k), morphs (t, v, 3)."""

    node: int
    vertices: Array
    faces: Ints
    movers: Ints
    weights: Array
    morphs: Array


@dataclass(frozen=True)
class RiggedMesh:
    """A mesh that follows the nodes of a glTF file.

    Attributes
    ----------
    file : GltfFile
    faces : (f, 3)
    remarks : tuple of str
        What was joined and welded.
    """

    file: GltfFile
    faces: Ints
    remarks: tuple[str, ...]
    _parts: tuple[_Part, ...]
    _kept: Ints
    _movers: tuple[tuple[int, Array], ...]

    def posed(self, changes: Changes) -> Array:
        """Vertices (v, 3) in the world, the nodes having what an animation gives them."""
        world = world_matrices(self.file, changes)
        motions = np.stack([world[node] @ bind for node, bind in self._movers])
        moved = []
        for part in self._parts:
            rows = np.repeat(np.arange(len(part.vertices)), part.movers.shape[1])
            entries = (part.weights.ravel(), (rows, part.movers.ravel()))
            weights = csr_array(entries, shape=(len(part.vertices), len(motions)))
            vertices = part.vertices + self._morphed(part, changes)
            moved.append(linear_blend_skinning(vertices, weights, motions[:, :3, :3], motions[:, :3, 3]))
        return np.concatenate(moved)[self._kept]

    def _morphed(self, part: _Part, changes: Changes) -> Array:
        """What the morph targets add to the vertices of a part."""
        if not len(part.morphs):
            return np.zeros_like(part.vertices)
        node = self.file.part("nodes", part.node)
        still = node.get("weights") or self.file.part("meshes", node["mesh"]).get("weights")
        shares = changes.get((part.node, "weights"), still)
        shares = np.zeros(len(part.morphs)) if shares is None else np.asarray(shares, dtype=np.float64)
        if shares.shape != (len(part.morphs),):
            raise InputError(
                f"{str(self.file.path)!r} weighs {shares.size} of {len(part.morphs)} morph targets; "
                "export it again"
            )
        return np.tensordot(shares, part.morphs, axes=1)


def rigged_mesh(file: GltfFile) -> RiggedMesh:
    """The surface of all meshes in the scene of a file.

    Vertices at one place with the same joints, weights and morph targets become one: an exporter splits them
    along seams of textures and normals, and between materials.

    Raises
    ------
    InputError
        If there is none, or it is damaged or compressed.
    """
    movers: dict[tuple[int, int], tuple[int, Array]] = {}
    parts: list[_Part] = []
    left_out = 0
    for number in _scene(file):
        node = file.part("nodes", number)
        if "mesh" not in node:
            continue
        mesh = file.part("meshes", node["mesh"])
        with file.checked(f"mesh {mesh.get('name', node['mesh'])!r}"):
            solid = [each for each in mesh["primitives"] if each.get("mode", TRIANGLES) in (4, 5, 6)]
            left_out += len(mesh["primitives"]) - len(solid)
            parts += [_part(file, number, node, each, movers) for each in solid]
    if parts:
        kept, faces, told = _welded(parts)
    if not parts or not len(faces):
        raise InputError(f"{str(file.path)!r} has no mesh of triangles in its scene; export one with it")
    told += [f"{len(parts)} primitives joined"] if len(parts) > 1 else []
    told += [f"{left_out} primitives of points or lines left out"] if left_out else []
    return RiggedMesh(file, faces, tuple(told), tuple(parts), kept, tuple(movers.values()))


def _scene(file: GltfFile) -> list[int]:
    """Numbers of the nodes of the scene that is shown; all without one."""
    nodes = file.content.get("nodes", [])
    if not file.content.get("scenes"):
        return list(range(len(nodes)))
    with file.checked("scene"):
        waiting = list(file.part("scenes", file.content.get("scene", 0)).get("nodes", ()))[::-1]
        found: list[int] = []
        while waiting:
            found.append(waiting.pop())
            waiting += file.part("nodes", found[-1]).get("children", ())[::-1]
            if len(found) > len(nodes):
                raise ValueError("a node is in it twice")
    return found


def _part(
    file: GltfFile,
    number: int,
    node: dict[str, Any],
    primitive: dict[str, Any],
    movers: dict[tuple[int, int], tuple[int, Array]],
) -> _Part:
    """One primitive of the mesh of a node; new movers are added to those that there are."""
    for name in primitive.get("extensions", {}):
        if "compression" in name:
            raise InputError(
                f"{str(file.path)!r} has a mesh with the glTF extension {name}, which is not read here; "
                "export it without (no compression)"
            )
    attributes = primitive["attributes"]
    vertices = file.array(attributes["POSITION"], 3).astype(np.float64)
    if not np.isfinite(vertices).all():
        raise ValueError("positions are NaN or infinite")
    faces = _faces(file, primitive, len(vertices))
    ids, weights = _binding(file, attributes, len(vertices)) if "skin" in node else (None, None)
    if ids is None or weights is None:
        place = _mover(movers, (-1 - number, 0), number, np.eye(4))
        ids, weights = np.full((len(vertices), 1), place), np.ones((len(vertices), 1))
    else:
        skin = file.part("skins", node["skin"])
        if ids.size and ids.max() >= len(skin["joints"]):
            raise ValueError(f"joint {ids.max()} of {len(skin['joints'])}")
        ids = _joint_movers(file, node["skin"], skin, movers)[ids]
    morphs = [
        file.array(target["POSITION"], 3).astype(np.float64)
        if "POSITION" in target
        else np.zeros_like(vertices)
        for target in primitive.get("targets", ())
    ]
    stacked = np.stack(morphs) if morphs else np.zeros((0, *vertices.shape))
    if stacked.shape[1:] != vertices.shape:
        raise ValueError(f"a morph target of {stacked.shape[1]} vertices for {len(vertices)}")
    return _Part(number, vertices, faces, ids, weights, stacked)


def _faces(file: GltfFile, primitive: dict[str, Any], vertices: int) -> Ints:
    """Triangles (f, 3) of a primitive, strips and fans cut into theirs."""
    given = file.array(primitive["indices"], 1).ravel() if "indices" in primitive else np.arange(vertices)
    if given.size and given.max() >= vertices:
        raise ValueError(f"a face names vertex {given.max()} of {vertices}")
    mode = primitive.get("mode", TRIANGLES)
    if mode == TRIANGLES:
        return given[: len(given) // 3 * 3].reshape(-1, 3).astype(np.int64)
    k = np.arange(max(len(given) - 2, 0))
    if mode == STRIP:  # every second one is wound the other way round
        corners = np.stack([k, k + 1 + k % 2, k + 2 - k % 2], axis=1)
    else:
        corners = np.stack([k + 1, k + 2, 0 * k], axis=1)
    faces: Ints = given[corners].astype(np.int64)
    return faces[~repeated_corners(faces)]


def _binding(
    file: GltfFile, attributes: dict[str, Any], vertices: int
) -> tuple[Ints, Array] | tuple[None, None]:
    """Joints and weights (v, 4 sets) of a primitive, rows summing to 1; None where it has none."""
    ids: list[Ints] = []
    weights: list[Array] = []
    while f"JOINTS_{len(ids)}" in attributes:
        weights.append(file.array(attributes[f"WEIGHTS_{len(ids)}"], 4).astype(np.float64))
        ids.append(file.array(attributes[f"JOINTS_{len(ids)}"], 4).astype(np.int64))
    if not ids:
        return None, None
    joints, shares = np.concatenate(ids, axis=1), np.concatenate(weights, axis=1)
    if len(joints) != vertices or len(shares) != vertices:
        raise ValueError(f"weights of {len(shares)} vertices, joints of {len(joints)}, {vertices} positions")
    total = shares.sum(axis=1)
    if not (np.isfinite(shares).all() and (shares >= 0).all() and (total > 0).all()):
        raise ValueError(f"{int((~(total > 0)).sum())} vertices have no weights, or wrong ones")
    joints[shares == 0] = joints[np.arange(vertices), shares.argmax(axis=1)].repeat((shares == 0).sum(axis=1))
    return joints, shares / total[:, None]


def _joint_movers(
    file: GltfFile, number: int, skin: dict[str, Any], movers: dict[tuple[int, int], tuple[int, Array]]
) -> Ints:
    """Mover of each joint of a skin: the joint's node, and its inverse bind matrix."""
    joints = skin["joints"]
    binds = np.tile(np.eye(4), (len(joints), 1, 1))
    if "inverseBindMatrices" in skin:
        stored = file.array(skin["inverseBindMatrices"], 16).astype(np.float64)
        if len(stored) < len(joints):
            raise ValueError(f"{len(stored)} inverse bind matrices of {len(joints)} joints")
        binds = stored[: len(joints)].reshape(-1, 4, 4).transpose(0, 2, 1)
    for joint in joints:
        file.part("nodes", joint)
    return np.array([_mover(movers, (number, k), joints[k], binds[k]) for k in range(len(joints))])


def _mover(
    movers: dict[tuple[int, int], tuple[int, Array]], key: tuple[int, int], node: int, bind: Array
) -> int:
    """Place of a mover among all, where it is added if it is new."""
    movers.setdefault(key, (node, bind))
    return list(movers).index(key)


def _welded(parts: list[_Part]) -> tuple[Ints, Ints, list[str]]:
    """Vertices that are kept of all parts, faces of these, and what was done, in words."""
    width = max(part.movers.shape[1] for part in parts)
    depth = max(len(part.morphs) for part in parts)
    rows, faces, start = [], [], 0
    for part in parts:
        free = ((0, 0), (0, width - part.movers.shape[1]))
        binding = _in_order(np.pad(part.movers + 1, free), np.pad(part.weights, free))
        morphs = np.pad(part.morphs, ((0, depth - len(part.morphs)), (0, 0), (0, 0)))
        flat = morphs.transpose(1, 0, 2).reshape(len(part.vertices), 3 * depth)
        rows.append(np.concatenate([part.vertices, binding, flat], axis=1))
        faces.append(part.faces + start)
        start += len(part.vertices)
    every, corners = np.concatenate(rows), np.concatenate(faces)
    used, corners = np.unique(corners, return_inverse=True)
    kept, place = first_at_places(every[used])
    joined = place[corners.reshape(-1, 3)]
    flat_ones = repeated_corners(joined)
    counts = {
        "vertices belong to no face: dropped": start - len(used),
        "vertices along seams of texture, normals or material: welded": len(used) - len(kept),
        "faces name a vertex twice once welded: dropped": int(flat_ones.sum()),
    }
    told = [f"{count:,} {what}" for what, count in counts.items() if count]
    return used[kept], joined[~flat_ones].astype(np.int64), told


def _in_order(movers: Ints, weights: Array) -> Array:
    """Movers, counted from 1, and weights (v, 2 k), sorted and equal movers of a row as one; 0 for none."""
    order = np.argsort(movers, axis=1, kind="stable")
    movers, weights = np.take_along_axis(movers, order, axis=1), np.take_along_axis(weights, order, axis=1)
    for k in range(movers.shape[1] - 1):
        same = movers[:, k] == movers[:, k + 1]
        weights[same, k + 1] += weights[same, k]
        weights[same, k] = 0
    shares = np.round(weights, DIGITS)
    names = np.where(shares > 0, movers, 0)
    order = np.argsort(names, axis=1, kind="stable")
    return np.concatenate([np.take_along_axis(each, order, axis=1) for each in (names, shares)], axis=1)
