"""Normals of clouds that have none, and signs that something is wrong with those given."""

import itertools
import logging
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from datasets_gen.points.normals import pca, spanning_tree
from datasets_gen.points.outside import outward_field, winding_numbers
from datasets_gen.points.strays import nearest_kept, stray_points
from datasets_gen.records import InputError
from medial.sides import Neighbours

log = logging.getLogger(__name__)

Float = NDArray[np.float64]
Ids = NDArray[np.int64]

NEIGHBOURS = 16
"""Of a point, in its PCA and in the spanning tree."""
DISAGREEING = 0.15
"""Share of neighbours with opposite normals from which other signs are tried; thin parts have up to .02."""
WORTH_IT = 0.02
"""Gain in the share of positive winding numbers for which other signs are taken."""
OUTWARD_SHARE = 0.65
"""Share of points with a positive winding number from which normals point outward, beyond doubt: right ones
have .99 or more, with noise of a whole spacing .78. From 1 - this on they point inward."""
FLAT = 1e-6
"""Winding number up to which the surface is a plane."""
SEAM = 1.0
"""Points at seams, over the square root of the number of points, from which sides are compared by seams as
well: right ones have up to 0.2, with noise of a whole spacing 1.8; a third of a body inward has 2 to 5."""
DOUBTFUL_SEAM = 2.0
"""Times as many that are worth saying where nothing is turned."""
FEWER_SEAMS = 0.5
"""Share of those points that other sides may leave at seams to be taken."""
MOST_TURNS = 6
"""Rounds of turning patches."""
SMALL_TURN = 0.05
"""Share of the points up to which inward patches are turned all at once."""
FEWEST_POINTS = 50
"""From here on the planes through neighbours tell whether normals belong to the points."""
FEW_POINTS = 500
"""Below this, planes go through fewer neighbours, and fits are compared with a margin for chance."""
FEW_NEIGHBOURS = 6
CHANCE = 0.5
"""That margin is this over the square root of the number of points, some two standard deviations."""
LEAST_FIT = 0.57
"""Mean cosine between normals and planes' normals: any directions have .5, right ones .8 to 1, and .6 with
noise of a whole spacing."""
BETTER_FIT = 0.05
"""How much better other axes must fit; right normals fit better than any others by .05 or more, with noise of
a whole spacing by .03."""
COLOURS_FIT = 0.8
"""Normals without a negative component are colours if they fit less than this."""
IN_DOUBT = 0.1
"""Share of estimated normals in doubt that is worth saying."""
ON_A_LINE = 1e-5
"""Largest sine between directions that count as one: rounding of single precision is below it."""


def estimate_normals(points: Float) -> Float:
    """Outward unit normals by PCA of the nearest points and a minimum spanning tree of their signs.

    Sides are voted for by the whole cloud (`datasets_gen.points.normals.spanning_tree`); where many votes are
    against the side taken, the log says so. Stray points get the normal of the nearest other one.

    Parameters
    ----------
    points : (n, 3)

    Returns
    -------
    (n, 3) float64

    Raises
    ------
    InputError
        If there are fewer than two points, or some more that all lie on one line.
    """
    if len(points) >= FEWEST_POINTS:
        _check_line(points)
    return _estimated(points)


def _estimated(points: Float) -> Float:
    """As `estimate_normals`; points on a line get any normals across it."""
    stray = stray_points(points)
    if stray.any():
        rest = np.asarray(points[~stray])
        return _estimated(rest)[nearest_kept(points, stray)]
    places, index = np.unique(points, axis=0, return_inverse=True)
    if 1 < len(places) < len(points):  # copies of a point are no neighbours: they span no plane
        return _estimated(places)[index.ravel()]
    neighbours = min(NEIGHBOURS, max(1, len(points) - 1))
    oriented = spanning_tree(points, pca(points, neighbours), neighbours)
    doubt = float((np.einsum("ij,ij->i", oriented, outward_field(points)) < 0).mean())
    if doubt > IN_DOUBT:
        log.warning("the side of %.0f %% of the estimated normals is in doubt", 100 * doubt)
    return oriented


def _check_line(points: Float) -> None:
    """Raise InputError if all points (n, 3) lie on one line, as seen from their median: it has no normals.

    Directions do not see how far a point is away, so that a stray one makes no line of a body.
    """
    spokes = points - np.median(points, axis=0)
    length = np.linalg.norm(spokes, axis=1)
    far = (length >= np.median(length)) & (length > 0)
    directions = spokes[far] / length[far, None]
    if far.any() and np.linalg.norm(np.cross(directions, directions[0]), axis=1).max() < ON_A_LINE:
        raise InputError(
            f"all {len(points)} points lie on one line, which has no normals; give a scan of a surface"
        )


def check_normals(points: Float, normals: Float) -> Float:
    """Correct normals that do not belong to the points or point inward; each change is a line in the log.

    Parameters
    ----------
    points : (n, 3)
        Distinct and without strays.
    normals : (n, 3)
        Unit.

    Returns
    -------
    (n, 3) float64
        The very same array where nothing is wrong.
    """
    reason = misfit(points, normals)
    if reason:
        log.warning("the normals do not belong to the points (%s): estimated anew", reason)
        return _estimated(points)
    return turned_outward(points, normals)


def misfit(points: Float, normals: Float) -> str:
    """Why normals cannot belong to the points, as an axis that was swapped or colours; empty if they may.

    The planes through each point's neighbours tell, whatever side the normals are on.
    """
    if len(points) < FEWEST_POINTS:
        return ""
    few = len(points) < FEW_POINTS
    chance = CHANCE / float(np.sqrt(len(points))) if few else 0.0
    planes = pca(points, FEW_NEIGHBOURS if few else NEIGHBOURS)
    moments = np.einsum("ni,nj->nij", planes, normals)
    fit, best, axes = _fit(moments, (0, 1, 2), (1, 1, 1)), 0.0, ""
    for order in itertools.permutations(range(3)):
        for signs in ((1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1)):
            value = _fit(moments, order, signs)
            if value > best:
                words = ("-" * (sign < 0) + "xyz"[axis] for axis, sign in zip(order, signs, strict=True))
                best, axes = value, " ".join(words)
    if best > max(fit + BETTER_FIT + chance, LEAST_FIT):
        return f"their components fit better in the order {axes}: mean cosine {best:.2f}, as given {fit:.2f}"
    if fit < COLOURS_FIT and normals.min() >= 0:
        return f"no component is negative, as of colours; mean cosine to the planes of neighbours {fit:.2f}"
    if fit < LEAST_FIT - chance:
        return f"mean cosine to the planes of neighbours {fit:.2f}; any directions have 0.5"
    return ""


def _fit(moments: Float, order: tuple[int, ...], signs: tuple[int, ...]) -> float:
    """Mean cosine between planes' normals and given ones with other axes: component i is +-order[i]."""
    terms = (sign * moments[:, i, axis] for i, (axis, sign) in enumerate(zip(order, signs, strict=True)))
    return float(np.abs(sum(terms)).mean())


def outward_share(points: Float, normals: Float) -> float:
    """Share of points that see the surface from within (`datasets_gen.points.outside.winding_numbers`).

    Near 1 for outward normals, near 0 for inward ones; 1/2 where the shape does not tell, as on a plane.
    """
    return _share(winding_numbers(points, normals))


def _share(winding: Float) -> float:
    """Share of positive numbers; those that are 0 up to rounding count half."""
    return float((winding > FLAT).mean() + (winding >= -FLAT).mean()) / 2


@dataclass(frozen=True)
class Sides:
    """Sides that normals may have.

    Attributes
    ----------
    turned : (n,) bool
        Which of the given normals are negated.
    doubtful : (d,) int64
        Ids of the points of patches that point neither way.
    share : float
        Of positive winding numbers.
    seams : int
        Number of points whose normals are opposite to those of neighbours in their tangent plane.
    """

    turned: NDArray[np.bool_]
    doubtful: Ids
    share: float
    seams: int


def turned_outward(points: Float, normals: Float) -> Float:
    """The normals, negated as a whole or on patches if they point inward there; the log says so.

    A patch is a connected part of the surface on which neighbouring normals agree. If patches point inward
    after all, signs look random, or patches meet at long seams, across which normals are opposite, other
    sides are tried as well: those that the whole cloud (`outward_field`) and a spanning tree vote for, and
    those without seams.
    """
    near, winding = Neighbours.of(points), winding_numbers(points, normals)
    patches, opposite = near.patches(normals), near.disagreement(normals)
    start = np.full(len(points), _share(winding) < 1 / 2)
    first = _settled(near, normals, patches, start, -winding if start.all() else winding)
    unclear = opposite > DISAGREEING or first.share < OUTWARD_SHARE or len(first.doubtful) > 0
    long = SEAM * float(np.sqrt(len(points)))
    best = first
    if unclear or first.seams > long or (first.turned != start).any():
        tree = spanning_tree(points, normals, min(NEIGHBOURS, len(points) - 1))
        against = np.einsum("ij,ij->i", tree, normals) < 0
        voted, seamless = _voted(points, normals, patches), near.without_seams(normals, patches)
        others = [_settled(near, normals, patches, each) for each in (~start, voted)]
        others += [_settled(near, normals, [], each) for each in (against, seamless, ~seamless)]
        best = _better(first, others, long)
    if not best.turned.any() and opposite > DISAGREEING:
        log.warning("%.0f %% of neighbouring normals point opposite ways", 100 * opposite)
    elif best.seams > DOUBTFUL_SEAM * long:
        log.warning("%d of %d normals are opposite to their neighbours' beside them", best.seams, len(points))
    doubtful = len(points) if best.share < OUTWARD_SHARE and not len(best.doubtful) else len(best.doubtful)
    if doubtful:
        log.warning("the side of %d of %d normals is in doubt", doubtful, len(points))
    if not best.turned.any():
        return normals
    seam = f"; {first.seams} were opposite to their neighbours' beside them" if first.seams > long else ""
    log.warning("%d of %d normals point inward: flipped%s", best.turned.sum(), len(points), seam)
    return _with(best.turned, normals)


def _better(first: Sides, others: list[Sides], long: float) -> Sides:
    """The sides with the largest share of positive winding numbers, unless those of `first` are as good.

    Of sides with long seams and sides that are as good with far fewer of them, the latter: a cap of a sphere
    sees positive winding numbers even where it points inward.
    """
    best = max([first, *others], key=lambda each: each.share)
    best = best if best.share > first.share + WORTH_IT else first
    fewest = min(
        (each for each in [best, *others] if each.share > best.share - WORTH_IT),
        key=lambda each: (each.seams, -each.share),
    )
    return fewest if best.seams > long and fewest.seams < FEWER_SEAMS * best.seams else best


def _settled(
    near: Neighbours,
    normals: Float,
    patches: list[Ids],
    turned: NDArray[np.bool_],
    winding: Float | None = None,
) -> Sides:
    """Turn patches that point inward, the largest first, until there are none."""
    turned = turned.copy()
    for step in range(MOST_TURNS):
        if step or winding is None:
            winding = winding_numbers(near.points, _with(turned, normals))
        inward = [ids for ids in patches if _share(winding[ids]) < 1 - OUTWARD_SHARE]
        if not inward or step == MOST_TURNS - 1:
            break
        largest = max(map(len, inward))
        for ids in inward:  # the largest alone, or all that are small: those hardly feel each other
            if len(ids) == largest or largest < SMALL_TURN * len(turned):
                turned[ids] = ~turned[ids]
    assert winding is not None
    doubtful = [ids for ids in patches if _share(winding[ids]) < OUTWARD_SHARE]
    seams = near.rows[near.at_seams(_with(turned, normals))]
    doubtful_ids = np.concatenate([*doubtful, np.empty(0, np.int64)])
    return Sides(turned, doubtful_ids, _share(winding), len(np.unique(seams)))


def _with(turned: NDArray[np.bool_], normals: Float) -> Float:
    """The normals, some of them negated."""
    return np.where(turned[:, None], -normals, normals)


def _voted(points: Float, normals: Float, patches: list[Ids]) -> NDArray[np.bool_]:
    """Which patches the field of the whole cloud wants turned, as a mask of the points."""
    against = np.einsum("ij,ij->i", normals, outward_field(points)) < 0
    turned = np.zeros(len(points), dtype=bool)
    for ids in patches:
        turned[ids] = against[ids].mean() > 0.5
    return turned
