"""The public face of medialbench: what a user needs in the first hour, on plain objects and arrays.

::

    import medialbench as mb

    body = mb.load("human")                                        # or a folder of posed meshes
    a = mb.scan(body["walk"], threshold=0.8, views=6, points=5000)
    b = mb.scan(body["sit"], threshold=0.8, views=6, points=5000)
    found = mb.match(a, b)
    print(mb.geodesic_error(found, a, b, body).mean())
    mb.plot(found, a, b).savefig("map.png")

This module only gathers: `datasets_gen` loads, `scanner_sim` scans, `medial` matches, `evaluation` scores and
`reports` draws; each is imported by the first call. Input that cannot be used raises `InputError`: one line.
"""

import os
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from datasets_gen import Collection, InputError, Shape
    from medial import Departures, Diffusion, MatchConfig, Matching
    from reports.ground_truth import score
    from scanner_sim import Scan

    __version__: str

__all__ = [
    "Departures",
    "Diffusion",
    "InputError",
    "MatchConfig",
    "Matching",
    "Scan",
    "__version__",
    "diffusion_error",
    "geodesic_error",
    "load",
    "match",
    "plot",
    "sample",
    "scan",
    "score",
    "symmetry",
]

_HOMES = dict.fromkeys(("Departures", "Diffusion", "MatchConfig", "Matching"), "medial")
_HOMES |= {"InputError": "datasets_gen", "Scan": "scanner_sim", "score": "reports.ground_truth"}


def __getattr__(name: str) -> Any:
    """Give a class, `score` or the version when it is asked for."""
    if name in _HOMES:
        return getattr(import_module(_HOMES[name]), name)
    if name == "__version__":
        from importlib.metadata import version

        return version("medialbench")
    raise AttributeError(f"module 'medialbench' has no attribute {name!r}; it has {', '.join(__all__)}")


def __dir__() -> list[str]:
    return __all__


def load(name: str | os.PathLike[str], **options: Any) -> "Collection":
    """Load the poses of one subject.

    Parameters
    ----------
    name
        Of `datasets_gen.names`, such as "human", a folder of poses or of a known data set, or a .glb or .gltf
    **options
        Those of `datasets_gen.bodies.built_in.load_body` (`seed`, ...) or of `datasets_gen.load_folder`.

    Returns
    -------
    Collection
        ``body["walk"]`` is the `Shape` of one pose; ``body.poses`` names them; ``body.reference`` is at rest.
    """
    from datasets_gen import registry

    return registry.load(name, **options)


def scan(
    mesh: Any,
    *,
    threshold: float | None = None,
    views: int | str | None = None,
    points: int | None = None,
    seed: int = 0,
    repair: bool = False,
    **settings: Any,
) -> "Scan":
    """Scan a mesh with the simulated laser scanner [BLN*11].

    Parameters
    ----------
    mesh
        A `Shape`, the path of a mesh file, a ``trimesh.Trimesh``, or (vertices, faces); open, in pieces, too.
    threshold
        Smallest accepted laser peak in (0, 1]; a higher one loses more surface. Default 0.1.
    views
        Viewpoints: a number, "sphere:N", "ring:N", "opposed" or one side as "front:2". Default 10.
    points
        Keep at most this many points, evenly spread. Default: all.
    seed
        Of the noise and of the choice of points.
    repair
        Go on with the largest component and without degenerate faces.
    **settings
        Further fields of `scanner_sim.ScannerConfig`: ``noise=0.1``, ``material="colours"`` (the mesh's own).

    Returns
    -------
    Scan
        Points and normals (n, 3) in the units of the mesh; every point knows its face and barycentrics.
    """
    import scanner_sim
    from datasets_gen import as_shape
    from datasets_gen.meshes.colours import colours_of

    given = {k: v for k, v in {"peak_threshold": threshold, "views": views}.items() if v is not None}
    config = scanner_sim.ScannerConfig.from_dict(given | settings)
    attributes = colours_of(mesh) if config.material == "colours" else None
    whole = scanner_sim.scan(as_shape(mesh, repair=repair, strict=False), config, seed, attributes)
    return whole if points is None else whole.subsample(points, seed)


def sample(mesh: Any, points: int, *, seed: int = 0) -> "Scan":
    """Sample a whole surface evenly, as an ideal scanner would.

    Parameters
    ----------
    mesh, points, seed
        As for `scan`; at least 1 point.

    Returns
    -------
    Scan
        With exact normals and ground truth.
    """
    from datasets_gen import as_shape
    from scanner_sim import sample as sample_shape

    return sample_shape(as_shape(mesh), points, seed)


def match(
    source: Any,
    target: Any,
    *,
    operator: str = "medial",
    points: int = 8000,
    modes: int = 300,
    config: "MatchConfig | str | None" = None,
    seed: int = 0,
    **settings: Any,
) -> "Matching":
    """Match every source point to a target point.

    Parameters
    ----------
    source, target
        Each a `Scan`, an (n, 3) array, a pair (points, normals), the path of a scan, cloud or mesh, a
        `Shape` or (vertices, faces), which are sampled, or a `Diffusion`. Missing normals are estimated.
    operator
        "medial" (the paper's), "heat" or "robust" (tufted Laplacian); that of a `Diffusion` wins.
    points
        Match at most this many, evenly spread; the others follow their nearest neighbour.
    modes, seed
        Eigenfunctions to use; seed of all samples.
    config
        Of the matcher: "default", "paper" (the settings of Sec. 4) or a `MatchConfig`.
    **settings
        Further fields of `medial.operator.Operator`; ``departures="none"`` is the paper (docs/paper.md).

    Returns
    -------
    Matching
        ``source_to_target`` (n,), target point ids or -1; ``confidence`` (n,) in [0, 1]; both clouds' points.
    """
    from medial import match as match_diffusions
    from reports.given_clouds import check_config, extended, prepared_pair

    check_config(config)
    here, there = prepared_pair(source, target, operator, points, modes, seed, settings)
    return extended(match_diffusions(here.diffusion, there.diffusion, config, seed), here, there)


def symmetry(
    cloud: Any,
    *,
    operator: str = "medial",
    points: int = 8000,
    modes: int = 300,
    config: "MatchConfig | str | None" = None,
    seed: int = 0,
    **settings: Any,
) -> "Matching":
    """Find the left-right symmetry of a cloud: the mirror image of every point (Sec. 5.2).

    Parameters
    ----------
    cloud, operator, points, modes, config, seed, **settings
        As for `match`.

    Returns
    -------
    Matching
        From the cloud to itself; its confidence is low where the other side was not scanned.
    """
    from medial import intrinsic_symmetry
    from reports.given_clouds import check_config, extended, prepared

    check_config(config)
    side = prepared(cloud, operator, points, modes, seed, settings)
    return extended(intrinsic_symmetry(side.diffusion, config, seed), side, side)


def geodesic_error(
    matching: "Matching", source: "Scan", target: "Scan", body: "Collection | Shape"
) -> "NDArray[np.float64]":
    """Distance between where each point was sent and where it belongs.

    Parameters
    ----------
    matching, source, target
        A map, and the scans that it matches: of two poses of one body (`scan`, `sample`).
    body
        The `Collection`, or the `Shape` of its rest pose, on which distances are measured.

    Returns
    -------
    (n,) float64
        Geodesic distance on the rest pose, x 100 / sqrt(area); nan where a point has no match.
    """
    from reports.ground_truth import geodesic_error_of_map

    return geodesic_error_of_map(matching, source, target, body)


def diffusion_error(
    scan: "Scan",
    body: "Collection | Shape",
    *,
    operator: str = "medial",
    modes: int = 300,
    seed: int = 0,
    **settings: Any,
) -> float:
    """Eq. 18: how far the diffusion of a scan is from that of the complete rest pose.

    Parameters
    ----------
    scan
        With ground truth (`scan`, `sample`).
    body
        The `Collection`, or the `Shape` of its rest pose. As many points of it as the scan has are sampled.
    operator, modes, seed, **settings
        As for `match`; errors of different operators, or ``departures``, cannot be compared.

    Returns
    -------
    float
        0 is perfect. `evaluation.diffusion_error` gives the terms of all times, too.
    """
    from reports.ground_truth import diffusion_error_of_scan

    return diffusion_error_of_scan(scan, body, operator, modes, seed, settings)


def plot(thing: Any, *others: Any, **options: Any) -> Any:
    """Draw anything: a shape, a body, a cloud, a diffusion, or a map with its clouds.

    Parameters
    ----------
    thing
        A `Shape`, a `Collection` (all poses), a `Scan`, an (n, 3) array or (points, normals), a `Diffusion`
        (medial centres and an eigenfunction), a `Matching`, or the path of a file of any of these.
    *others
        Of a `Matching`, its two clouds; without them it is drawn on the points that it holds.
    **options
        ``up`` ("x", "y" or "z"), ``height`` (pixels); of a `Diffusion`, ``mode`` (which eigenfunction); of a
        map or a cloud, ``interactive=True`` for a view that can be turned.

    Returns
    -------
    matplotlib.figure.Figure or InteractiveView
        Shows in a notebook; ``.savefig("a.png")``, of a view ``.save("a.html")``, writes it.
    """
    from reports.draw import draw

    return draw(thing, *others, **options)
