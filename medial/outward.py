"""Normals of clouds that have none, and signs that something is wrong with those given."""

import itertools
import logging

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from datasets_gen.compiled import thread_count
from datasets_gen.points.normals import pca, spanning_tree
from datasets_gen.points.outside import outward_field, winding_numbers
from datasets_gen.points.strays import nearest_kept, stray_points

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
PATCH_NEIGHBOURS, SMALLEST_PATCH, PATCH_SHARE = 6, 20, 0.005
"""Points of a patch whose side is decided by itself, and their share of all."""
MOST_TURNS = 6
"""Rounds of turning patches."""
SMALL_TURN = 0.05
"""Share of the points up to which inward patches are turned all at once."""
ENOUGH_POINTS = 500
"""From here on the planes through neighbours tell whether normals belong to the points."""
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
        If there are fewer than two points.
    """
    stray = stray_points(points)
    if stray.any():
        rest = np.asarray(points[~stray])
        return estimate_normals(rest)[nearest_kept(points, stray)]
    neighbours = min(NEIGHBOURS, max(1, len(points) - 1))
    oriented = spanning_tree(points, pca(points, neighbours), neighbours)
    doubt = float((np.einsum("ij,ij->i", oriented, outward_field(points)) < 0).mean())
    if doubt > IN_DOUBT:
        log.warning("the side of %.0f %% of the estimated normals is in doubt", 100 * doubt)
    return oriented


def disagreement(points: Float, normals: Float) -> float:
    """Share of pairs of near neighbours whose normals point into opposite half spaces."""
    count = min(7, len(points))
    _, neighbours = cKDTree(points).query(points, k=count, workers=thread_count())
    return float((np.einsum("ij,ikj->ik", normals, normals[neighbours[:, 1:]]) < 0).mean())


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
        return estimate_normals(points)
    return turned_outward(points, normals)


def misfit(points: Float, normals: Float) -> str:
    """Why normals cannot belong to the points, as an axis that was swapped or colours; empty if they may.

    The planes through each point's neighbours tell, whatever side the normals are on.
    """
    if len(points) < ENOUGH_POINTS:
        return ""
    planes = pca(points, NEIGHBOURS)
    moments = np.einsum("ni,nj->nij", planes, normals)
    fit, best, axes = _fit(moments, (0, 1, 2), (1, 1, 1)), 0.0, ""
    for order in itertools.permutations(range(3)):
        for signs in ((1, 1, 1), (1, 1, -1), (1, -1, 1), (-1, 1, 1)):
            value = _fit(moments, order, signs)
            if value > best:
                words = ("-" * (sign < 0) + "xyz"[axis] for axis, sign in zip(order, signs, strict=True))
                best, axes = value, " ".join(words)
    if best > max(fit + BETTER_FIT, LEAST_FIT):
        return f"their components fit better in the order {axes}: mean cosine {best:.2f}, as given {fit:.2f}"
    if fit < COLOURS_FIT and normals.min() >= 0:
        return f"no component is negative, as of colours; mean cosine to the planes of neighbours {fit:.2f}"
    if fit < LEAST_FIT:
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


def turned_outward(points: Float, normals: Float) -> Float:
    """The normals, negated as a whole or on patches if they point inward there; the log says so.

    A patch is a connected part of the surface on which neighbouring normals agree. If patches point inward
    after all, or signs look random, the sides that the whole cloud (`outward_field`) and a spanning tree vote
    for are tried as well; what has the largest share of positive winding numbers is taken.
    """
    patches = _patches(points, normals)
    winding = winding_numbers(points, normals)
    start = np.full(len(points), _share(winding) < 1 / 2)
    found = [_settled(points, normals, patches, start, -winding if start.all() else winding)]
    opposite = disagreement(points, normals)
    unclear = opposite > DISAGREEING or found[0][2] < OUTWARD_SHARE or len(found[0][1]) > 0
    if unclear or (found[0][0] != start).any():
        tree = spanning_tree(points, normals, min(NEIGHBOURS, len(points) - 1))
        against = np.einsum("ij,ij->i", tree, normals) < 0
        voted = _voted(points, normals, patches)
        found += [_settled(points, normals, patches, each, None) for each in (~start, voted)]
        found += [_settled(points, normals, [], against, None)]
    best = max(found, key=lambda each: each[2])
    turned, doubtful, share = best if best[2] > found[0][2] + WORTH_IT else found[0]
    if not turned.any() and opposite > DISAGREEING:
        log.warning("%.0f %% of neighbouring normals point opposite ways", 100 * opposite)
    if share < OUTWARD_SHARE and not len(doubtful):
        doubtful = np.arange(len(points))
    if len(doubtful):
        log.warning("the side of %d of %d normals is in doubt", len(doubtful), len(points))
    if not turned.any():
        return normals
    log.warning("%d of %d normals point inward: flipped", turned.sum(), len(points))
    return np.where(turned[:, None], -normals, normals)


def _settled(
    points: Float, normals: Float, patches: list[Ids], turned: NDArray[np.bool_], winding: Float | None
) -> tuple[NDArray[np.bool_], Ids, float]:
    """Turn patches that point inward, the largest first, until there are none.

    Returns
    -------
    turned : (n,) bool
    doubtful : ids of the points of patches that point neither way
    share : float
        Of positive winding numbers.
    """
    turned = turned.copy()
    for step in range(MOST_TURNS):
        if step or winding is None:
            winding = winding_numbers(points, np.where(turned[:, None], -normals, normals))
        inward = [ids for ids in patches if _share(winding[ids]) < 1 - OUTWARD_SHARE]
        if not inward or step == MOST_TURNS - 1:
            break
        largest = max(map(len, inward))
        for ids in inward:  # the largest alone, or all that are small: those hardly feel each other
            if len(ids) == largest or largest < SMALL_TURN * len(points):
                turned[ids] = ~turned[ids]
    assert winding is not None
    doubtful = [ids for ids in patches if _share(winding[ids]) < OUTWARD_SHARE]
    return turned, np.concatenate([*doubtful, np.empty(0, np.int64)]), _share(winding)


def _voted(points: Float, normals: Float, patches: list[Ids]) -> NDArray[np.bool_]:
    """Which patches the field of the whole cloud wants turned, as a mask of the points."""
    against = np.einsum("ij,ij->i", normals, outward_field(points)) < 0
    turned = np.zeros(len(points), dtype=bool)
    for ids in patches:
        turned[ids] = against[ids].mean() > 0.5
    return turned


def _patches(points: Float, normals: Float) -> list[Ids]:
    """Point ids of every connected part of the surface on which neighbouring normals agree, if large enough.

    Neighbours on opposite sheets of a thin part are no neighbours here.
    """
    n = len(points)
    count = min(PATCH_NEIGHBOURS, n - 1) + 1
    gap, near = cKDTree(points).query(points, k=count, workers=thread_count())
    rows = np.repeat(np.arange(n), count - 1)
    columns, gap = near[:, 1:].ravel(), gap[:, 1:].ravel()
    offset = points[columns] - points[rows]
    agree = np.einsum("ij,ij->i", normals[rows], normals[columns]) > 0.5
    agree &= np.abs(np.einsum("ij,ij->i", offset, normals[rows])) < 0.5 * gap
    edges = (np.ones(agree.sum()), (rows[agree], columns[agree]))
    label = connected_components(coo_array(edges, shape=(n, n)), directed=False)[1]
    order = np.argsort(label, kind="stable")
    parts = np.split(order, np.flatnonzero(np.diff(label[order])) + 1)
    least = max(SMALLEST_PATCH, PATCH_SHARE * n)
    return [part for part in parts if len(part) >= least]
