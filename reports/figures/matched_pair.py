"""Two scanned poses and a map between them, as the figures of the paper draw them."""

from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen import Collection
from evaluation import correspondence_error
from evaluation.metrics.correspondence import least_errors
from evaluation.metrics.geodesic import SurfaceDistance
from evaluation.metrics.mirror_images import mirror_points
from medial import Matching, match
from reports.figures.cloud_drawing import carried_colors, colored_from, position_colors
from reports.figures.cloud_sheet import CloudPanel
from reports.figures.figure_request import (
    FigureRequest,
    ScannedPose,
    cloud_table,
    front_view,
    map_errors,
    surface_places,
)

SHARED = 0.75
"""Distance of medial centres up to which points share a colour, in radii of the ball."""
ALONE = (
    "A target point to which nothing is mapped has the colour of the nearest medial centre with one, "
    f"within {SHARED:g} radii."
)


@dataclass(frozen=True)
class MatchedPair:
    """Two scanned poses and a map.

    Attributes
    ----------
    body : Collection
    source, target : ScannedPose
    found : Matching
    errors : (n_source,) float64
        Geodesic, x 100 / sqrt(area); nan where there is no match.
    """

    body: Collection
    source: ScannedPose
    target: ScannedPose
    found: Matching
    errors: NDArray[np.float64]

    @classmethod
    def of(
        cls,
        request: FigureRequest,
        body: Collection,
        source: ScannedPose,
        target: ScannedPose,
        operator: str = "medial",
        config: str = "default",
    ) -> "MatchedPair":
        """Match two poses; the medial operators are those of the poses, others are built."""
        here, there = (
            each.diffusion if operator == "medial" else request.diffusion(each.scan, operator)
            for each in (source, target)
        )
        request.tell(f"matching {source.shape.name} and {target.shape.name} ({operator})")
        found = match(here, there, config, request.seed)
        return cls(body, source, target, found, map_errors(body, source, target, found.source_to_target))

    @property
    def error_words(self) -> str:
        """Mean and median error in words."""
        return f"mean error {np.nanmean(self.errors):.1f}, median {np.nanmedian(self.errors):.1f}"

    @property
    def chance_words(self) -> str:
        """The least mean error that these scans allow, and the probability of the map, in words."""
        least = f"the least that a map of these scans can have is {self.least_mean:.1f}"
        if np.isnan(self.found.probability):
            return least
        return f"{least}; probability of the map {self.found.probability:.2f}"

    @property
    def least_mean(self) -> float:
        """Least mean error, x 100 / sqrt(area), that any map of these scans can have."""
        ends = surface_places(self.body, self.source, self.target)
        rest = self.body.reference
        return 100 * float(least_errors(SurfaceDistance(rest), *ends, rest.area).mean())

    @property
    def mirrored_mean(self) -> float:
        """Mean error from the mirror images of the true places; nan where the body has no mirror map."""
        return mirrored_mean(self.body, self.source, self.target, self.found.source_to_target)

    def colours(self, by: str = "medial") -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Colours of the source and those that arrive at the target.

        Parameters
        ----------
        by : {"medial", "position"}
            Of the source: where its medial centres (Eq. 9) lie, or its points. With the former a target
            point to which nothing is mapped takes the colour of its medial region (`regional_colours`).
        """
        if by == "position":
            places = self.source.scan.points
            own = position_colors(places, *np.quantile(places, [0.01, 0.99], axis=0))
            return own, carried_colors(self.found.source_to_target, own, self.target.scan.points)
        places = self.source.diffusion.centers
        own = position_colors(places, *np.quantile(places, [0.01, 0.99], axis=0))
        return own, regional_colours(self.found.source_to_target, own, self.target)

    def panel(
        self, side: int, colors: NDArray[np.float64], turned: float = 0, landmarks: bool = True, **words: str
    ) -> CloudPanel:
        """The source (side 0) or the target (1) in some colours, seen from the front or turned from it."""
        each = (self.source, self.target)[side]
        shown: Any = {"title": each.shape.pose, "note": each.note} | words
        return CloudPanel(
            each.scan.points,
            each.scan.normals,
            colors,
            front_view(self.body, turned),
            self.body.reference.diagonal,
            landmarks=self.found.landmarks[:, side] if landmarks else np.zeros(0, np.int64),
            **shown,
        )

    def table(self, panel: str = "", **columns: Any) -> pd.DataFrame:
        """The points of both clouds, with the map, its confidence and errors, and its landmarks.

        Parameters
        ----------
        panel
            Name of the pair.
        **columns
            Further ones of the source.
        """
        marks = []
        for side, each in enumerate((self.source, self.target)):
            number = np.zeros(len(each.scan), np.int64)
            number[self.found.landmarks[:, side]] = np.arange(1, len(self.found.landmarks) + 1)
            marks.append(number)
        here = cloud_table(
            f"{panel} source".strip(),
            self.source,
            landmark=marks[0],
            target_point=self.found.source_to_target,
            confidence=self.found.confidence,
            error=self.errors,
            **columns,
        )
        there = cloud_table(f"{panel} target".strip(), self.target, landmark=marks[1])
        return pd.concat([here, there], ignore_index=True)


def regional_colours(
    image: NDArray[np.integer], colors: NDArray[np.float64], target: ScannedPose
) -> NDArray[np.float64]:
    """Colours that arrive at a target, where points share them with the others on their medial ball.

    A map of medial regions is unique up to the points on one ball (Sec. 4): a point to which nothing is
    mapped takes the colour of the nearest medial centre that has one, within `SHARED` radii of its ball.

    Parameters
    ----------
    image : (n,)
        Target point of every source point; -1 for no match.
    colors : (n, 3)
        Of the source.
    target

    Returns
    -------
    (m, 3) float64
    """
    found = carried_colors(image, colors, target.scan.points)
    origin = colored_from(image, target.scan.points)
    reached, bare = np.unique(image[image >= 0]), np.flatnonzero(origin < 0)
    if len(reached) and len(bare):
        centers = target.diffusion.centers
        gap, nearest = cKDTree(centers[reached]).query(centers[bare])
        near = gap <= SHARED * target.diffusion.radii[bare]
        found[bare[near]] = found[reached[nearest[near]]]
    return found


def mirrored_mean(
    body: Collection, source: ScannedPose, target: ScannedPose, image: NDArray[np.integer]
) -> float:
    """Mean distance, x 100 / sqrt(area), of where points are sent from where their mirror images belong.

    Small for a map that swaps left and right, and for a symmetry.

    Parameters
    ----------
    body, source, target
    image : (n_source,)
        Target point of every source point; -1 for no match.

    Returns
    -------
    float
        nan where the body has no mirror map.
    """
    if body.mirror is None:
        return float("nan")
    rest = body.reference
    here, there = surface_places(body, source, target)
    other_side = mirror_points(rest, body.mirror, there)
    errors = correspondence_error(SurfaceDistance(rest), here, other_side, image, rest.area)
    return 100 * float(np.nanmean(errors))
