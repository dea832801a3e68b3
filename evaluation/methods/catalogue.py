"""Names of methods to classes, the built-in ones and yours."""

import importlib.util
import sys
from collections.abc import Mapping
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from types import ModuleType
from typing import Any

from datasets_gen.extras import pip_install
from datasets_gen.fingerprints import code_fingerprint
from datasets_gen.records import InputError
from datasets_gen.values import did_you_mean
from evaluation.experiment.toml_tables import reject_unknown
from evaluation.methods.base import Method
from evaluation.results.outcome import one_line

METHODS: dict[str, str] = {
    "medial": "evaluation.methods.spectral:Medial",
    "heat": "evaluation.methods.spectral:Heat",
    "robust": "evaluation.methods.spectral:Robust",
    "truth-landmarks": "evaluation.methods.ceiling:TruthLandmarks",
    "rigid": "evaluation.methods.rigid:RigidNearest",
    "geodesic-graph": "evaluation.methods.geodesic_graph:GeodesicGraph",
    "functional-maps": "evaluation.methods.functional:FunctionalMaps",
    "cpd": "evaluation.methods.cpd:CoherentPointDrift",
    "skeleton": "evaluation.methods.skeleton_matching:SkeletonMatching",
    "external": "evaluation.methods.external:External",
}
"""Name in tables and TOML files, and where the class is: imported only when it is used."""


def find(name: str) -> type[Method]:
    """The class of a method.

    Parameters
    ----------
    name
        A key of `METHODS`, ``"package.module:Class"`` or ``"path/to/file.py:Class"``.

    Raises
    ------
    InputError
        If there is no such method, or it is none.
    """
    reference = METHODS.get(name, name)
    if ":" not in reference:
        reject_unknown([name], METHODS, "experiment", "method")
    home, _, attribute = reference.rpartition(":")
    module = _module(home)
    cls = getattr(module, attribute, None)
    if cls is None:
        own = [n for n, each in vars(module).items() if getattr(each, "__module__", "") == module.__name__]
        said = did_you_mean(attribute, own)
        raise InputError(f"{name!r} is no method: {home!r} has no {attribute!r}{said.rstrip(';')}")
    if not (isinstance(cls, type) and issubclass(cls, Method)):
        raise InputError(
            f"{name!r} is no method: {attribute!r} in {home!r} does not derive from evaluation.methods.Method"
        )
    return cls


def create(name: str, options: Mapping[str, Any]) -> Method:
    """A method with its options.

    Raises
    ------
    InputError
        If the name or an option is unknown.
    """
    try:
        return find(name).from_options(options)
    except InputError:
        raise
    except (Exception, SystemExit) as error:  # whatever the user's code does
        raise InputError(f"method {name!r} cannot be made ({one_line(error)})") from error


def missing(name: str) -> str:
    """Why a method cannot run here: the packages it lacks and how to get them; empty if it can."""
    lacking = {module: pip for module, pip in find(name).requires.items() if find_spec(module) is None}
    if not lacking:
        return ""
    command = pip_install("peers")
    if name not in METHODS:
        command = f"pip install {' '.join(dict.fromkeys(lacking.values()))}"
    return f"method {name!r} needs {', '.join(lacking)}: {command}"


def method_version(name: str, method: Method) -> str:
    """Version of a method's own code and files."""
    home = METHODS.get(name, name).rpartition(":")[0]
    return code_fingerprint(home) + method.fingerprint()


def _module(home: str) -> ModuleType:
    if not home.endswith(".py"):
        try:
            return import_module(home)
        except (Exception, SystemExit) as error:
            raise InputError(
                f"cannot import {home!r} ({one_line(error)}); give 'package.module:Class' or 'file.py:Class'"
            ) from error
    path = Path(home).resolve()
    name = f"medialbench_method_{path.stem}"
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None or not path.is_file():
        raise InputError(f"no Python file {home!r}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    try:
        spec.loader.exec_module(module)
    except (Exception, SystemExit) as error:
        del sys.modules[name]
        raise InputError(f"cannot import {home!r} ({one_line(error)}); correct it") from error
    return module
