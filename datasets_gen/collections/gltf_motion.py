"""How the nodes of a glTF file move: the hierarchy, and animations sampled at any time."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from datasets_gen.collections.gltf_buffers import GltfFile
from datasets_gen.records import InputError

Array = NDArray[np.float64]

PATHS = {"translation": 3, "rotation": 4, "scale": 3, "weights": 1}
"""What an animation may change of a node, and the numbers of each stored value."""
Changes = dict[tuple[int, str], Array]
"""Values of nodes by number and path."""


@dataclass(frozen=True)
class Track:
    """Keyframes of one property of one node.

    Attributes
    ----------
    node : int
    path : str
        A key of `PATHS`.
    interpolation : str
        ``"LINEAR"``, ``"STEP"`` or ``"CUBICSPLINE"``.
    times : (k,)
        Seconds, ascending.
    values : (k, n), or (k, 3, n) with tangents before and after
    """

    node: int
    path: str
    interpolation: str
    times: Array
    values: Array

    def at(self, time: float) -> Array:
        """The value (n,) at a time; before the first and after the last key that of the key."""
        times, values = self.times, self.values
        time = float(np.clip(time, times[0], times[-1]))
        k = int(np.clip(np.searchsorted(times, time, side="right") - 1, 0, len(times) - 1))
        if self.interpolation == "CUBICSPLINE":
            return self._cubic(time, k)
        if self.interpolation == "STEP" or k == len(times) - 1:
            return values[k]
        if self.path == "rotation":  # the shorter way round
            keys = Rotation.from_quat(values[k : k + 2])
            found: Array = Slerp(times[k : k + 2], keys)(time).as_quat()
            return found
        share = (time - times[k]) / (times[k + 1] - times[k])
        return (1 - share) * values[k] + share * values[k + 1]

    def _cubic(self, time: float, k: int) -> Array:
        """Hermite spline through keys whose tangents before and after may differ."""
        if k == len(self.times) - 1:
            return self.values[k, 1]
        step = self.times[k + 1] - self.times[k]
        t = (time - self.times[k]) / step
        (_, start, leaving), (arriving, end, _) = self.values[k : k + 2]
        found: Array = (
            (2 * t**3 - 3 * t**2 + 1) * start
            + step * (t**3 - 2 * t**2 + t) * leaving
            + (3 * t**2 - 2 * t**3) * end
            + step * (t**3 - t**2) * arriving
        )
        return found


def animation_names(file: GltfFile) -> list[str]:
    """Names of the animations, each once: ``animation-2`` for one without, ``walk (2)`` for a second."""
    names: list[str] = []
    with file.checked("animations"):
        for number, animation in enumerate(file.content.get("animations", [])):
            name = str(animation.get("name") or f"animation-{number + 1}")
            same = sum(each == name or each.startswith(f"{name} (") for each in names)
            names.append(f"{name} ({same + 1})" if same else name)
    return names


def tracks_of(file: GltfFile, number: int) -> list[Track]:
    """Keyframes of an animation.

    Raises
    ------
    InputError
        If it is damaged, or moves by an extension that is not read here.
    """
    animation = file.part("animations", number)
    found = []
    with file.checked(f"animation {animation_names(file)[number]!r}"):
        for channel in animation["channels"]:
            target, sampler = channel["target"], animation["samplers"][channel["sampler"]]
            if target["path"] not in PATHS:
                raise InputError(
                    f"{str(file.path)!r} animates {target['path']!r}"
                    f"{''.join(f' by {each}' for each in target.get('extensions', ()))}, which is not read "
                    "here; bake the animation before exporting"
                )
            if "node" in target:
                file.part("nodes", target["node"])
                found.append(_track(file, target["node"], target["path"], sampler))
    return found


def _track(file: GltfFile, node: int, path: str, sampler: dict[str, Any]) -> Track:
    times = file.array(sampler["input"], 1).ravel().astype(np.float64)
    values = file.array(sampler["output"], PATHS[path]).astype(np.float64)
    kind = sampler.get("interpolation", "LINEAR")
    if kind not in ("LINEAR", "STEP", "CUBICSPLINE"):
        raise ValueError(f"interpolation {kind!r}")
    if not len(times) or not (np.diff(times) > 0).all() or not np.isfinite(times).all():
        raise ValueError("its times do not ascend")
    parts = 3 if kind == "CUBICSPLINE" else 1
    if values.size == 0 or values.size % (len(times) * parts) or not np.isfinite(values).all():
        raise ValueError(f"{len(times)} times, {values.size} values")
    shape = (len(times), 3, -1) if parts == 3 else (len(times), -1)
    values = values.reshape(shape)
    if path != "weights" and values.shape[-1] != PATHS[path]:
        raise ValueError(f"{len(times)} times, {len(values)} values of {path}")
    keys = values[:, 1] if parts == 3 else values
    if path == "rotation" and not (keys != 0).any(axis=1).all():
        raise ValueError("a rotation of four zeros")
    return Track(node, path, kind, times, values)


def world_matrices(file: GltfFile, changes: Changes) -> Array:
    """Matrices (nodes, 4, 4) from each node to the world.

    Parameters
    ----------
    file
    changes
        Values that an animation gives to nodes; the others are as the file has them.

    Raises
    ------
    InputError
        If the nodes form no trees.
    """
    nodes = file.content.get("nodes", [])
    with file.checked("nodes"):
        local = [_local(node, number, changes) for number, node in enumerate(nodes)]
        parents = parents_of(file)
    world = np.empty((len(nodes), 4, 4))
    done = np.zeros(len(nodes), dtype=bool)
    for number in range(len(nodes)):
        chain = [number]
        while not done[chain[-1]] and parents[chain[-1]] >= 0:
            chain.append(parents[chain[-1]])
            if len(chain) > len(nodes):
                raise InputError(f"{str(file.path)!r} has nodes that are their own parents; export it again")
        for each in reversed(chain):
            if not done[each]:
                world[each] = local[each] if parents[each] < 0 else world[parents[each]] @ local[each]
                done[each] = True
    return world


def parents_of(file: GltfFile) -> NDArray[np.int64]:
    """Number of the parent of each node, (nodes,); -1 for roots."""
    nodes = file.content.get("nodes", [])
    parents = np.full(len(nodes), -1, dtype=np.int64)
    for number, node in enumerate(nodes):
        for child in node.get("children", ()):
            file.part("nodes", child)
            parents[child] = number
    return parents


def _local(node: dict[str, Any], number: int, changes: Changes) -> Array:
    """Matrix (4, 4) from a node to its parent."""
    if "matrix" in node:
        return np.array(node["matrix"], dtype=np.float64).reshape(4, 4).T
    plain = {"translation": (0, 0, 0), "rotation": (0, 0, 0, 1), "scale": (1, 1, 1)}
    shift, turn, scale = (
        np.asarray(changes.get((number, path), node.get(path, default)), dtype=np.float64)
        for path, default in plain.items()
    )
    found = np.eye(4)
    found[:3, :3] = Rotation.from_quat(turn).as_matrix() * scale.reshape(1, 3)
    found[:3, 3] = shift
    return found
