"""Scenes of one result: a map that was found, or a scan."""

from collections.abc import Mapping

import numpy as np
from numpy.typing import NDArray

from medial import Diffusion, Matching
from medial.spectrum.times import logarithmic_times
from reports.figures.cloud_drawing import position_colors
from reports.viewer.scene import Scene, ViewCloud, ViewField, ViewMap
from scanner_sim import Scan

FRAMES = 8
"""Times of the signature that the slider goes through."""
SIGNATURE = "m_t(x, x) over its mean"


def view_of_map(
    clouds: tuple[Scan, Scan],
    names: tuple[str, str],
    found: Matching,
    operators: tuple[Diffusion | None, Diffusion | None] = (None, None),
    title: str = "",
) -> Scene:
    """A map between two clouds, with each other map that may be right instead.

    Parameters
    ----------
    clouds
        The matched points of source and target; the same cloud twice for a symmetry.
    names
    found
    operators
        The medial diffusions of both, for medial centres and signatures; None where there is none.
    title
        Default: the names.
    """
    own = clouds[0] is clouds[1]
    places = operators[0].centers if operators[0] is not None else clouds[0].points
    colors = position_colors(places, *np.quantile(places, [0.01, 0.99], axis=0))
    label = "medial centre (Eq. 9)" if operators[0] is not None else "place"
    fields = signatures([each for each in operators if each is not None])
    shown = [
        ViewCloud(
            name=name,
            points=cloud.points,
            normals=cloud.normals,
            caption=f"{len(cloud):,} points",
            colors=colors if k == 0 else None,
            color_label=label if k == 0 else "",
            centers=None if operator is None else operator.centers,
            fields=() if operator is None else (fields[id(operator)],),
        )
        for k, (cloud, name, operator) in enumerate(zip(clouds, names, operators, strict=True))
    ]
    maps = [_map(found, "symmetry" if own else "map", 0 if own else 1)]
    maps += [
        _map(each, f"alternative {k}", 0 if own else 1)
        for k, each in enumerate(found.as_alternatives(), start=2)
    ]
    return Scene(
        title=title or " to ".join(names),
        clouds=tuple(shown[: 1 if own else 2]),
        maps=tuple(maps),
        up="xyz".index(clouds[0].config.up),
    )


def _map(found: Matching, label: str, target: int) -> ViewMap:
    known = np.isfinite(found.probability)
    note = f"probability {found.probability:.2f}" if known else ""
    return ViewMap(
        label=label,
        image=found.source_to_target,
        target=target,
        note=note,
        confidence=found.confidence,
        landmarks=found.landmarks,
    )


def signatures(operators: list[Diffusion]) -> Mapping[int, ViewField]:
    """The signature m_t(x, x) of diffusions at common times, over its mean on the cloud, on one scale.

    Returns
    -------
    Mapping of int to ViewField
        By the identity of the diffusion.
    """
    if not operators:
        return {}
    times = logarithmic_times(*(each.eigenvalues for each in operators), count=FRAMES)
    values: list[NDArray[np.float64]] = []
    for each in operators:
        signature = each.signature(times)
        values.append((signature / np.maximum(signature.mean(axis=0), 1e-300)).T)
    top = float(np.quantile(np.concatenate([each.ravel() for each in values]), 0.99))
    frames = tuple(f"time {k + 1} of {len(times)} (t = {t:.3g})" for k, t in enumerate(times))
    return {
        id(each): ViewField("signature", SIGNATURE, value, 0.0, top, frames)
        for each, value in zip(operators, values, strict=True)
    }


def view_of_scan(scan: Scan, name: str, most: int = 60000) -> Scene:
    """A scan, with a slider for the peak threshold where it knows its peaks.

    Parameters
    ----------
    scan
    name
    most
        Points to show at most, evenly spread over the file.
    """
    picked = np.arange(len(scan))
    if len(picked) > most:
        picked = np.linspace(0, len(scan) - 1, most).round().astype(np.int64)
    cloud = scan.select(picked)
    fields = []
    scanned = bool(len(cloud)) and bool((cloud.view_ids >= 0).all())
    if scanned:
        low = float(cloud.intensity.min())
        fields.append(ViewField("peak", "fitted peak", cloud.intensity, low, float(cloud.intensity.max())))
        views = cloud.view_ids.astype(np.float64)
        fields.append(ViewField("view", "number of the view", views, 0.0, max(float(views.max()), 1.0)))
        off = scan.scale * np.linalg.norm(cloud.points - cloud.true_points, axis=1)
        top = float(np.quantile(off, 0.99)) or 1.0
        fields.append(ViewField("residual", "distance from the true point, mm", off, 0.0, top))
    count = f"{len(scan):,} points" + (f", {len(picked):,} shown" if len(picked) < len(scan) else "")
    finite = np.isfinite(cloud.normals).all()
    shown = ViewCloud(
        name=name,
        points=cloud.points,
        normals=cloud.normals if finite else None,
        caption=count,
        fields=tuple(fields),
    )
    return Scene(
        title=name, clouds=(shown,), up="xyz".index(scan.config.up), threshold_on="peak" if scanned else ""
    )
