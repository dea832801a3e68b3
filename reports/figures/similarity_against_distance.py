"""Fig. 2 of the paper, measured: distance between medial points against medial similarity, on a scan.

The paper sketches that phi (Eq. 7) stands for a Gaussian of the distance between medial points without
knowing these. Here both are computed on a scan: a slice of it with the medial points (Eq. 9) of one point and
of some partners, the same slice with their candidate balls, and all pairs of many points.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from datasets_gen.records import InputError
from medial import similarity
from medial.areas.surface_cells import density_weights, surface_areas
from medial.similarity.candidate_ball import smallest_width
from medial.similarity.equations import candidate_balls, medial_similarity, normal_deviation, summed_depth
from reports.figures.cloud_sheet import EDGE, LINE, CloudSheet, note_lines, put_note
from reports.figures.figure_request import FigureRequest, MadeFigure, ScannedPose
from reports.figures.medial_slice import Slice, slice_of
from reports.figures.style import GRID, INK, QUIET, blank, plain_numbers, styled

POSE = "rest"
THRESHOLD = 0.3
POINTS = 3000
ROWS = 300
"""Points whose pairs with all others are drawn."""
PARTNERS = ("#d55e00", "#0072b2", "#009e73")
SIDE, TALL = 3.1, 2.4
FLOOR = 1e-6
"""Smallest similarity that is drawn: the cut-off of the operator."""


@dataclass(frozen=True)
class PairSimilarity:
    """What Eqs. 4-7 give for pairs of one point with others, all (m,) or (m, 3).

    Attributes
    ----------
    centers, radii
        Candidate balls; radius 0 where there is none.
    tau, gamma, phi
        Eqs. 4, 5 and 7.
    """

    centers: NDArray[np.float64]
    radii: NDArray[np.float64]
    tau: NDArray[np.float64]
    gamma: NDArray[np.float64]
    phi: NDArray[np.float64]


def similarity_of_pairs(
    each: ScannedPose, i: int, others: NDArray[np.integer], weights: NDArray[np.float64], cap: float
) -> PairSimilarity:
    """Eqs. 4-7 of a point with others, by the equations as written, with the weights and cap of the code.

    Parameters
    ----------
    each
    i, others
        Point ids.
    weights : (n,)
        How much each point counts in Eq. 5 (`medial.density_weights`).
    cap
        Largest radius of a candidate ball.
    """
    points, normals = each.scan.points, each.scan.normals
    centers, radii = candidate_balls(points[i], points[others], normals[i], normals[others])
    there = (radii > 0) & (radii <= cap)
    tau, gamma, phi = np.full(len(others), np.nan), np.full(len(others), np.nan), np.zeros(len(others))
    some = np.flatnonzero(there)
    balls = centers[some], radii[some]
    tau[some] = normal_deviation(points[i], points[others[some]], normals[i], normals[others[some]], *balls)
    gamma[some] = summed_depth(*balls, points, weights)
    phi[some] = medial_similarity(gamma[some], tau[some])
    return PairSimilarity(centers, np.where(there, radii, 0.0), tau, gamma, phi)


@styled
def similarity_against_distance(request: FigureRequest) -> MadeFigure:
    """Compare phi with the distance between medial points on one scan.

    Parameters
    ----------
    request

    Raises
    ------
    InputError
        If no point of the scan shares a medial ball with others around it.
    """
    body = request.body("human")
    shape = request.shapes(body, (POSE,), 1)[0]
    threshold, points = request.threshold(THRESHOLD), request.count(POINTS)
    each = ScannedPose.of(request, shape, threshold, 10, points)
    request.tell("similarities of pairs")
    normals = each.diffusion.normals
    weights = density_weights(surface_areas(each.scan.points, normals))
    cap = smallest_width(each.scan.points)
    table = _table(each, weights, request.seed)
    slab = slice_of(each)
    partners = _partners(each, slab, weights, cap)
    note = (
        f"{shape.name}, 10 views, threshold {threshold:g}, {each.note}, seed {request.seed}. Left: a slice "
        "across the body, its points (grey), and the medial points (Eq. 9, crosses) of p and of three "
        "partners; lines are the distances between medial points that a Gaussian α would be taken of. "
        "Middle: the outlines of the same pairs' candidate balls, and φ (Eq. 7): no medial point is "
        f"needed. Right: all pairs of {min(ROWS, len(each.scan))} points with φ of at least {FLOOR:g}; the "
        "line joins medians. Distances are in average sampling distances."
    )
    settings = {"shape": shape.name, "threshold": threshold, "points": points, "seed": request.seed}
    return MadeFigure(_drawn(each, slab, partners, table, note), table, settings)


def _table(each: ScannedPose, weights: NDArray[np.float64], seed: int) -> pd.DataFrame:
    """Pairs of some points with all others that have a similarity of at least `FLOOR`."""
    points, normals, n = each.scan.points, each.diffusion.normals, len(each.scan)
    rows = np.sort(np.random.default_rng(seed).permutation(n)[:ROWS])
    phi = similarity(points, normals, cutoff=FLOOR, weights=weights)[rows].tocoo()
    i, j = rows[phi.row], phi.col
    centers, radii = candidate_balls(points[i], points[j], normals[i], normals[j])
    gap = np.linalg.norm(each.diffusion.centers[i] - each.diffusion.centers[j], axis=1)
    columns = {"i": i, "j": j, "medial_distance": gap, "medial_distance_in_spacings": gap / each.spacing}
    columns |= {
        "ball_radius": radii,
        "tau": normal_deviation(points[i], points[j], normals[i], normals[j], centers, radii),
        "gamma": _depths(centers, radii, points, weights),
        "phi": phi.data,
    }
    return pd.DataFrame(columns)


def _depths(
    centers: NDArray[np.float64],
    radii: NDArray[np.float64],
    points: NDArray[np.float64],
    weights: NDArray[np.float64],
) -> NDArray[np.float64]:
    """Eq. 5 of many balls, a part at a time, of the points near each: no others lie in it."""
    tree, found = cKDTree(points), np.zeros(len(centers))
    for k, inside in enumerate(tree.query_ball_point(centers, radii)):
        found[k] = summed_depth(centers[k : k + 1], radii[k : k + 1], points[inside], weights[inside])[0]
    return found


def _partners(
    each: ScannedPose, slab: Slice, weights: NDArray[np.float64], cap: float
) -> list[tuple[int, PairSimilarity]]:
    """Partners of the slice's point: of the greatest similarity, a middling one, and hardly any."""
    others = slab.members[slab.members != slab.middle]
    apart = np.linalg.norm(each.scan.points[others] - each.scan.points[slab.middle], axis=1)
    others = others[apart > 0.7 * each.diffusion.radii[slab.middle]]
    found = similarity_of_pairs(each, slab.middle, others, weights, cap)
    kept = np.flatnonzero(found.radii > 0)
    if len(kept) == 0:
        raise InputError("no two points of the slice have a candidate ball; give more points or another pose")
    gap = np.linalg.norm(each.diffusion.centers[others] - each.diffusion.centers[slab.middle], axis=1)
    chosen = [int(kept[found.phi[kept].argmax()])]
    for least, most in ((0.05, 0.6), (-1.0, 1e-3)):
        some = kept[(found.phi[kept] > least) & (found.phi[kept] < most)]
        chosen += [int(some[gap[some].argmax()])] if len(some) else []
    return [
        (
            int(others[k]),
            similarity_of_pairs(each, slab.middle, others[k : k + 1], weights, cap),
        )
        for k in dict.fromkeys(chosen)
    ]


def _drawn(
    each: ScannedPose,
    slab: Slice,
    partners: Sequence[tuple[int, PairSimilarity]],
    table: pd.DataFrame,
    note: str,
) -> Figure:
    width = 2 * SIDE + 0.3 + 3.9
    lines = note_lines(note, width)
    sheet = CloudSheet(width, TALL + 1.15 + LINE * len(lines))
    left = sheet.axes(EDGE, 0.42, SIDE, TALL)
    middle = sheet.axes(EDGE + SIDE + 0.2, 0.42, SIDE, TALL)
    right = sheet.axes(EDGE + 2 * SIDE + 0.95, 0.42, 2.9, TALL)
    _slice_panel(left, each, slab, partners, balls=False)
    _slice_panel(middle, each, slab, partners, balls=True)
    _scatter(right, table)
    put_note(sheet, lines, TALL + 1.02)
    return sheet.figure


def _slice_panel(
    axes: Axes, each: ScannedPose, slab: Slice, partners: Sequence[tuple[int, PairSimilarity]], balls: bool
) -> None:
    """The slice with the medial points of the pairs, or with their candidate balls."""
    blank(axes)
    ring = slab.flat(each, each.scan.points[slab.members])
    axes.plot(*ring.T, ".", color=QUIET, ms=2.5, mew=0, alpha=0.8, rasterized=True)
    p = slab.flat(each, each.scan.points[slab.middle])
    shown = [ring]
    for _, pair in partners:
        shown += [
            slab.flat(each, pair.centers) - pair.radii[0],
            slab.flat(each, pair.centers) + pair.radii[0],
        ]
    low, high = (f(np.concatenate(shown), axis=0) for f in (np.min, np.max))
    scale = 1.12 * max((high - low) / [SIDE, TALL])
    for (j, pair), color, name in zip(partners, PARTNERS, "qrs", strict=False):
        q = slab.flat(each, each.scan.points[j])
        if balls:
            axes.add_patch(
                Circle(tuple(slab.flat(each, pair.centers[0])), pair.radii[0], fill=False, ec=color, lw=1.4)
            )
        else:
            own, other = (slab.flat(each, each.diffusion.centers[k]) for k in (slab.middle, j))
            axes.plot(*zip(p, own, strict=True), color=GRID, lw=1)
            axes.plot(*zip(q, other, strict=True), color=color, lw=0.8, alpha=0.5)
            axes.plot(*zip(own, other, strict=True), color=color, lw=1.8)
            axes.plot(*other, "x", color=color, ms=6, mew=1.6)
            axes.plot(*own, "x", color=INK, ms=6, mew=1.6)
        _named(axes, q, name, color)
    _named(axes, p, "p", INK)
    x, y = (low + high) / 2
    axes.set_xlim(x - scale * SIDE / 2, x + scale * SIDE / 2)
    axes.set_ylim(y - scale * TALL / 2, y + scale * TALL / 2)
    axes.set_title("candidate balls and φ" if balls else "distance of medial points")
    for number, ((j, pair), color, name) in enumerate(zip(partners, PARTNERS, "qrs", strict=False)):
        gap = np.linalg.norm(each.diffusion.centers[j] - each.diffusion.centers[slab.middle])
        likely = f"= {pair.phi[0]:.2g}" if pair.phi[0] >= FLOOR else f"< {FLOOR:g}"
        words = f"φ(p, {name}) {likely}" if balls else f"|p̂ − {name}̂| = {gap / each.spacing:.1f}"
        axes.text(
            0.33 * number,
            -0.02,
            words,
            transform=axes.transAxes,
            va="top",
            fontsize=7,
            color=color,
        )


def _named(axes: Axes, place: NDArray[np.float64], name: str, color: str) -> None:
    axes.plot(*place, "o", color=color, ms=5, mec="white", mew=0.7, zorder=5)
    x, y = 9 * place / max(float(np.linalg.norm(place)), 1e-300)
    axes.annotate(
        name,
        (place[0], place[1]),
        xytext=(x, y),
        textcoords="offset points",
        ha="center",
        va="center",
        color=color,
    )


def _scatter(axes: Axes, table: pd.DataFrame) -> None:
    """Similarity of all pairs against the distance between their medial points."""
    gap, phi = table["medial_distance_in_spacings"].to_numpy(), table["phi"].to_numpy()
    axes.plot(gap, phi, ".", color="#56b4e9", ms=2, mew=0, alpha=0.25, rasterized=True)
    edges = np.linspace(0, np.quantile(gap, 0.995), 16)
    place = np.digitize(gap, edges)
    middles = [(edges[k - 1] + edges[k]) / 2 for k in range(1, 16) if (place == k).sum() >= 5]
    medians = [np.median(phi[place == k]) for k in range(1, 16) if (place == k).sum() >= 5]
    axes.plot(middles, medians, "-o", color=INK, ms=3.5)
    axes.set_yscale("log")
    plain_numbers(axes.yaxis)
    axes.set_ylim(FLOOR, 1.5)
    axes.set_xlim(0, edges[-1])
    axes.set_xlabel("distance between medial points, spacings")
    axes.set_ylabel("medial similarity φ (Eq. 7)")
    axes.set_title(f"{len(table):,} pairs")
