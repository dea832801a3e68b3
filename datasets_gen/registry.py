"""Collections by name: built-in bodies and folders of meshes."""

import difflib
import inspect
import logging
import os
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, TypeVar

from datasets_gen.bodies import human, quadruped
from datasets_gen.bodies.body_plan import BodyPlan, build_body
from datasets_gen.cache import cache_path, fetch, store
from datasets_gen.collection import Collection
from datasets_gen.collections.folder import load_folder, outline_folder, pose_list
from datasets_gen.records import InputError
from datasets_gen.values import check_seed, check_types

T = TypeVar("T")

_log = logging.getLogger(__name__)

BUILT_IN: dict[str, Callable[[int], BodyPlan]] = {
    "human": human.plan,
    "human_asymmetric": human.asymmetric_plan,
    "quadruped": quadruped.plan,
}


def names() -> tuple[str, ...]:
    """Names of the built-in collections."""
    return tuple(BUILT_IN)


def provenance(name: str, seed: int = 0) -> dict[str, Any]:
    """What the manifest of a written built-in body says about where it comes from.

    Raises
    ------
    InputError
        If there is no built-in body of that name.
    """
    if name not in BUILT_IN:
        raise InputError(f"{name!r} is not built in; built in: {', '.join(names())}")
    return {"licence": "MIT", "source": f"procedural body {name!r} of medialbench", "seed": seed}


def load(name: str | os.PathLike[str], **options: Any) -> Collection:
    """Load the poses of one subject.

    Parameters
    ----------
    name
        A built-in body (`names`) or the path of a folder with one mesh file per pose.
    **options
        Of a built-in body: `seed` (int; proportions, 0 is the default body; the subject of another seed
        is called like ``human-3``) and `poses` (names, default all). Of a folder: those of `load_folder`.

    Raises
    ------
    InputError
        If the name is neither, or an option is not known.
    """
    _check_name(name)
    if str(name) in BUILT_IN:
        return _called(_load_built_in, str(name), options)
    if str(name) and Path(name).is_dir():
        return _called(load_folder, str(name), options)
    raise _unknown(name)


def outline(name: str | os.PathLike[str], **options: Any) -> dict[str, Any]:
    """What `load` would give, told without building or reading a mesh.

    Parameters
    ----------
    name, **options
        As for `load`.

    Returns
    -------
    dict
        ``subject`` (str), ``poses`` (list of str, in order), ``reference`` (str).

    Raises
    ------
    InputError
        As `load` does for names and options; contents of mesh files are not looked at.
    """
    _check_name(name)
    if str(name) in BUILT_IN:
        return _called(_outline_built_in, str(name), options)
    if str(name) and Path(name).is_dir():
        return _called(outline_folder, str(name), options)
    raise _unknown(name)


def _outline_built_in(name: str, *, seed: int = 0, poses: Sequence[str] | None = None) -> dict[str, Any]:
    check_seed(seed, f"seed of {name!r}")
    known = list(BUILT_IN[name](0).poses)
    subject = f"{name}-{seed}" if seed else name
    return {
        "subject": subject,
        "poses": known if poses is None else pose_list(poses, known, name),
        "reference": known[0],
    }


def _unknown(name: str | os.PathLike[str]) -> InputError:
    close = difflib.get_close_matches(str(name), names(), n=1, cutoff=0.4)
    hint = f"did you mean {close[0]!r}?" if close else f"built in: {', '.join(names())}"
    return InputError(f"no dataset {str(name)!r}, and no folder of that name; {hint}")


def _check_name(name: Any) -> None:
    if not isinstance(name, str | os.PathLike):
        raise InputError(
            f"{name!r} is no data set; give the path of a folder, or one of {', '.join(names())}"
        )


def _called(loader: Callable[..., T], name: str, options: dict[str, Any]) -> T:
    known = list(inspect.signature(loader).parameters)[1:]
    for option in options:
        if option not in known:
            raise InputError(f"dataset {name!r} has no option {option!r}; it has {', '.join(known)}")
    check_types(
        loader, {key: value for key, value in options.items() if key not in ("seed", "poses")}, "option"
    )
    return loader(name, **options)


def _load_built_in(name: str, *, seed: int = 0, poses: Sequence[str] | None = None) -> Collection:
    check_seed(seed, f"seed of {name!r}")
    chosen = None if poses is None else pose_list(poses, tuple(BUILT_IN[name](0).poses), name)
    path = cache_path(name, {"seed": int(seed)}, BUILT_IN[name].__module__)
    collection = fetch(path)
    if collection is None:
        _log.info("building %r with seed %d", name, seed)
        plan = BUILT_IN[name](int(seed))
        collection = build_body(replace(plan, name=f"{name}-{seed}") if seed else plan)
        store(path, collection)
    if chosen is None:
        return collection
    return replace(collection, shapes=tuple(collection[pose] for pose in chosen))
