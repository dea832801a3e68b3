"""What a figure of the paper is asked for, the clouds it is made of, and what it hands back."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen import Collection, InputError, Shape, load
from datasets_gen.values import check_count, check_seed
from evaluation import correspondence_error
from evaluation.metrics.correspondence import SurfacePoints
from evaluation.metrics.geodesic import SurfaceDistance
from medial import Diffusion
from reports.figures.point_renderer import best_azimuth, look_from
from scanner_sim import Scan, ScannerConfig, coverage, scan

RESOLUTION = (250, 250)
"""Pixels of the camera: enough for the points of a figure."""
MODES = 200
LEAST_POINTS = 100
UP = 1
"""Axis that points upwards in built-in bodies."""


@dataclass(frozen=True)
class FigureRequest:
    """A figure of the paper, and what may be chosen in it.

    Attributes
    ----------
    number : int
        In the paper.
    dataset : str or None
        Name or folder of a collection; None takes the figure's own.
    poses : tuple of str
        Empty takes the figure's own, or the first ones of another data set.
    thresholds : tuple of float
        Peak thresholds of the scanner; empty takes the figure's own.
    seed : int
        Of the scanner, the choice of points and the matcher.
    points : int or None
        Of every cloud.
    tell : callable
        Told what is done next.

    Raises
    ------
    InputError
        If a number is out of its range.
    """

    number: int
    dataset: str | None = None
    poses: tuple[str, ...] = ()
    thresholds: tuple[float, ...] = ()
    seed: int = 0
    points: int | None = None
    tell: Callable[[str], None] = print

    def __post_init__(self) -> None:
        """Check the numbers."""
        check_seed(self.seed)
        if self.points is not None:
            check_count(self.points, "points", LEAST_POINTS)
        for value in self.thresholds:
            if not 0 < value <= 1:
                raise InputError(f"threshold is {value!r}; give a number in (0, 1]")

    def body(self, own: str) -> Collection:
        """The collection that is asked for, or the figure's own."""
        self.tell(f"loading {self.dataset or own}")
        return load(self.dataset or own)

    def shapes(
        self, body: Collection, own: Sequence[str], least: int, most: int | None = None
    ) -> list[Shape]:
        """Poses of a body.

        Parameters
        ----------
        body
        own
            Of the figure, for its own body.
        least, most
            Number of poses that the figure shows; `most` is that of `own` if not given.

        Raises
        ------
        InputError
            If there are fewer, or more are asked for.
        """
        most = len(own) if most is None else most
        if self.poses:
            if not least <= len(self.poses) <= most:
                many = f"{least}" if least == most else f"{least} to {most}"
                raise InputError(
                    f"figure {self.number} shows {many} poses, got {len(self.poses)} "
                    f"({', '.join(self.poses)})"
                )
            return [body[pose] for pose in self.poses]
        wanted = [pose for pose in own if pose in body.poses] if self.dataset is None else []
        chosen = wanted or list(body.poses[:most])
        if len(chosen) < least:
            raise InputError(
                f"figure {self.number} needs {least} poses, {body.subject!r} has {len(body)}; "
                "give a data set with more"
            )
        return [body[pose] for pose in chosen]

    def threshold(self, own: float) -> float:
        """The one threshold of a figure.

        Raises
        ------
        InputError
            If several are given.
        """
        if len(self.thresholds) > 1:
            raise InputError(f"figure {self.number} has one threshold, got {len(self.thresholds)}; give one")
        return self.thresholds[0] if self.thresholds else own

    def count(self, own: int) -> int:
        """Points of every cloud."""
        return self.points or own

    def whole_scan(self, shape: Shape, threshold: float, views: str | int) -> Scan:
        """All points of a simulated scan; InputError if nothing is seen."""
        self.tell(f"scanning {shape.name}")
        config = ScannerConfig(views=views, peak_threshold=threshold, resolution=RESOLUTION)
        found = scan(shape, config, self.seed)
        if len(found) < LEAST_POINTS:
            raise InputError(
                f"a scan of {shape.name!r} at threshold {threshold:g} has {len(found)} points; "
                "give a lower threshold"
            )
        return found

    def diffusion(self, cloud: Scan, operator: str = "medial") -> Diffusion:
        """The operator on a cloud."""
        self.tell(f"{operator} operator of {cloud.shape_name}")
        modes = min(MODES, len(cloud) // 4)
        return Diffusion.from_points(cloud.points, cloud.normals, operator=operator, modes=modes)


@dataclass(frozen=True)
class ScannedPose:
    """A pose, its scan and its medial diffusion.

    Attributes
    ----------
    shape : Shape
    scan : Scan
    diffusion : Diffusion
    missing : float
        Share of the surface that was not acquired.
    """

    shape: Shape
    scan: Scan
    diffusion: Diffusion
    missing: float

    @classmethod
    def of(
        cls, request: FigureRequest, shape: Shape, threshold: float, views: str | int, points: int
    ) -> "ScannedPose":
        """Scan a pose, thin it out, and build its operator."""
        whole = request.whole_scan(shape, threshold, views)
        missing = 1 - coverage(whole, shape)
        cloud = whole.subsample(points, request.seed)
        return cls(shape, cloud, request.diffusion(cloud), missing)

    @property
    def spacing(self) -> float:
        """Average sampling distance: the mean distance of a point from the nearest other one."""
        return float(cKDTree(self.scan.points).query(self.scan.points, k=2)[0][:, 1].mean())

    @property
    def note(self) -> str:
        """Points and missing surface in words."""
        return f"{len(self.scan):,} points, {100 * self.missing:.0f} % missing"


class TwoPoses(NamedTuple):
    """A body, and two of its poses as they are scanned: threshold and points of a cloud, and the seed."""

    body: Collection
    source: ScannedPose
    target: ScannedPose
    threshold: float
    points: int
    seed: int

    @classmethod
    def of(
        cls,
        request: FigureRequest,
        body: str,
        poses: Sequence[str],
        threshold: float,
        views: Sequence[str | int],
        points: int,
    ) -> "TwoPoses":
        """Scan two poses.

        Parameters
        ----------
        request
        body, poses, threshold, points
            The figure's own, unless others are asked for: data set, poses, peak threshold, points of a cloud.
        views
            Viewpoints of the source and of the target.

        Raises
        ------
        InputError
            If the data set has fewer than two poses, or a scan sees too little.
        """
        found = request.body(body)
        shapes = request.shapes(found, poses, 2)
        tau, count = request.threshold(threshold), request.count(points)
        source, target = (
            ScannedPose.of(request, shape, tau, view, count)
            for shape, view in zip(shapes, views, strict=True)
        )
        return cls(found, source, target, tau, count, request.seed)

    @property
    def settings(self) -> dict[str, Any]:
        """What a figure of them notes."""
        poses = [self.source.shape.name, self.target.shape.name]
        return {"poses": poses, "threshold": self.threshold, "points": self.points, "seed": self.seed}


def map_errors(
    body: Collection, source: ScannedPose, target: ScannedPose, image: NDArray[np.integer]
) -> NDArray[np.float64]:
    """Geodesic error of a map x 100 / sqrt(area) per source point, (n,), nan for -1."""
    ends, rest = surface_places(body, source, target), body.reference
    return 100 * correspondence_error(SurfaceDistance(rest), *ends, image, rest.area)


def surface_places(
    body: Collection, source: ScannedPose, target: ScannedPose
) -> tuple[SurfacePoints, SurfacePoints]:
    """Where the points of two scanned poses lie on the body's rest pose."""
    here, there = (
        SurfacePoints(*body.on_reference(each.shape, each.scan.face_ids, each.scan.barycentrics))
        for each in (source, target)
    )
    return here, there


@dataclass(frozen=True)
class MadeFigure:
    """A figure and the numbers behind it.

    Attributes
    ----------
    figure : Figure
    table : DataFrame
        What is drawn, for the CSV.
    settings : dict
        What it was made of, for the origin of the CSV.
    """

    figure: Figure
    table: pd.DataFrame
    settings: dict[str, Any]


def front_view(body: Collection, turned: float = 0.0) -> NDArray[np.float64]:
    """Rotation of a camera that shows a body's widest side from its front, turned about the up axis.

    Parameters
    ----------
    body
    turned
        Degrees.
    """
    azimuth = best_azimuth(body.reference.vertices, UP)
    return look_from(turned + (azimuth - 180 if azimuth > 90 else azimuth), up=UP)


def cloud_table(panel: str, each: ScannedPose, **columns: Any) -> pd.DataFrame:
    """A row per point: its place, its medial centre and radius (Eq. 9), and further columns."""
    scan_, found = each.scan, each.diffusion
    places = {f"{axis}": scan_.points[:, k] for k, axis in enumerate("xyz")}
    centres = {f"centre_{axis}": found.centers[:, k] for k, axis in enumerate("xyz")}
    head = {"panel": panel, "cloud": scan_.shape_name, "point": np.arange(len(scan_))}
    return pd.DataFrame(head | places | centres | {"radius": found.radii} | columns)
