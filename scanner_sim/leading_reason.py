"""Why a scan acquired nothing: the reason that most camera rays share, and the remedy that fits it."""

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from scanner_sim.optics.hits import Hits
from scanner_sim.optics.verdict import Verdict, verdicts
from scanner_sim.scanner_config import ScannerConfig

if TYPE_CHECKING:
    from scanner_sim.optics.measurement import ViewMeasurement

_REMEDIES = {
    Verdict.SHADOW: ("lie in the laser's shadow", "lower baseline or add views"),
    Verdict.GRAZING: (
        "face the laser too obliquely for peak_threshold {threshold:g}",
        "lower peak_threshold or add views",
    ),
    Verdict.DARK: (
        "return too little light for peak_threshold {threshold:g}",
        "raise exposure or gain, lower peak_threshold, or choose a brighter material",
    ),
    Verdict.SATURATED: ("saturate the sensor", "lower exposure or gain"),
    Verdict.OUT_OF_RANGE: (
        "lie at {near:.4g}..{far:.4g} mm, outside the swept {low:.4g}..{high:.4g} mm",
        "change distance, min_range or max_range",
    ),
    Verdict.POOR_FIT: (
        "give no clean peak",
        "lower the noise, or raise std_threshold, residual_threshold or depth_threshold",
    ),
}
"""What is said of the hits with a verdict, and what to do."""


def nothing_acquired(
    name: str,
    views: "list[tuple[Hits, ViewMeasurement]]",
    configs: list[ScannerConfig],
    in_image: list[bool],
) -> str:
    """One line on why no point was acquired.

    Parameters
    ----------
    name
        Of the shape.
    views
        Hits of every view and what was measured of them.
    configs
        Of the camera of each view.
    in_image
        Whether the image of each view could show the object.
    """
    config, number = configs[0], f"{len(views)} view{'s' if len(views) > 1 else ''}"
    judged = [_judged(*view, its) for view, its in zip(views, configs, strict=True)]
    verdict, distance = (np.concatenate(parts) for parts in zip(*judged, strict=True))
    counts = np.bincount(verdict, minlength=len(Verdict))
    counts[[Verdict.MISS, Verdict.ACCEPTED]] = 0
    if not counts.any():
        return f"none of {number} sees {name!r}: {_blindness(in_image)}"
    leading = Verdict(int(counts.argmax()))
    distance = distance[verdict == leading]
    what, remedy = _REMEDIES[leading]
    what = what.format(
        threshold=config.peak_threshold,
        near=distance.min(),
        far=distance.max(),
        low=config.min_range,
        high=config.max_range,
    )
    others = [
        f"{counts[v]:,} {v.name.lower().replace('_', ' ')}" for v in _REMEDIES if v != leading and counts[v]
    ]
    also = f" (also {', '.join(others)})" if others else ""
    return (
        f"no point of {name!r} was acquired from {number}: {counts[leading]:,} of "
        f"{counts.sum():,} hits {what}{also}; {remedy}"
    )


def _judged(
    hits: Hits, measured: "ViewMeasurement", config: ScannerConfig
) -> tuple[NDArray[np.int8], NDArray[np.float64]]:
    """Verdict on each hit of the object and its distance, (n,); out of range counts in shadow, too."""
    verdict = verdicts(hits, measured.index, measured.verdict, config)
    distance = np.linalg.norm(hits.points, axis=1)
    if config.motion == "sweep":  # a profiler's points are not in the coordinates of their frame's camera
        outside = (distance < config.min_range - 1e-6) | (distance > config.max_range + 1e-6)
        verdict[outside] = Verdict.OUT_OF_RANGE
    mine = hits.face_ids >= 0
    return verdict[mine], distance[mine]


def _blindness(in_image: list[bool]) -> str:
    """Why views have no hit, and what to do."""
    if any(in_image):
        return (
            "they look at the backs of its faces, or it is smaller than a pixel; turn the faces round, look "
            "from the other side or come nearer"
        )
    return "it lies outside their images; aim the cameras at it, or change distance or field_of_view"


def shows(vertices: NDArray[np.float64], config: ScannerConfig) -> bool:
    """Whether the image of a camera could show an object with vertices (v, 3) in camera coordinates."""
    ahead = vertices[vertices[:, 2] > 1e-6]
    image = np.abs(ahead[:, :2] / ahead[:, 2:]) * config.focal
    return bool((image <= np.array(config.resolution) / 2).all(axis=1).any())
