"""Landmarks and their partners by diffusion: the greedy search of Sec. 4 (Eq. 16)."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

from datasets_gen.compiled import compiled
from datasets_gen.points.farthest import farthest_in_embedding
from medial.matching.config import MatchConfig
from medial.matching.landmarks.descriptors import DiffusionDescriptors, middle_time
from medial.matching.landmarks.samples import diffusion_map
from medial.matching.nearest import over_blocks

Float32 = NDArray[np.float32]
Float64 = NDArray[np.float64]

PARTNERS_APART = 0.5
"""Alternatives are apart by this part of the target's root mean square extent in the diffusion map."""


def landmark_order(
    cloud: DiffusionDescriptors, times: NDArray[np.float64], start: int, count: int
) -> NDArray[np.int64]:
    """Positions in `cloud.samples` of samples far apart in the diffusion map at the middle time, (count,)."""
    embedding = diffusion_map(cloud.diffusion, middle_time(times), cloud.samples)
    return farthest_in_embedding(embedding, count, start)


def search_landmarks(
    source: DiffusionDescriptors,
    target: DiffusionDescriptors,
    order: NDArray[np.int64],
    config: MatchConfig,
    first_partner: int | None = None,
) -> NDArray[np.int64]:
    """Partners of a sequence of source samples, found greedily with Eq. 16.

    Coordinates of landmarks found before are appended to those of a new one, so that it has to agree with
    them: squared distances simply add up.

    Parameters
    ----------
    source, target
    order : (L,) int64
        Positions in `source.samples`.
    config
    first_partner
        Partner of the first landmark, if it is given; a position in `target.samples`.

    Returns
    -------
    (L,) int64
        Positions in `target.samples`.
    """
    partners = np.empty(len(order), dtype=np.int64)
    agreement = np.zeros((len(target.samples), len(source.samples)), dtype=np.float32)
    for step, landmark in enumerate(order):
        if step == 0 and first_partner is not None:
            candidates = np.array([first_partner])
        else:
            candidates = nearest_signatures(source.signature[landmark], target.signature, config.candidates)
        coordinates = source.among_samples(int(landmark))
        others = [target.among_samples(int(each)) for each in candidates]
        best = int(candidate_costs(agreement, coordinates, others).argmin())
        partners[step] = candidates[best]
        product, square_x, square_y = _square_parts(coordinates, others[best])
        agreement += product + square_y[:, None] + square_x
    return partners


def first_partners(
    source: DiffusionDescriptors,
    target: DiffusionDescriptors,
    landmark: int,
    config: MatchConfig,
    time: float,
) -> NDArray[np.int64]:
    """Partners of a first landmark by Eq. 16, best first, that lie apart from each other.

    Left and right, and sometimes arm and leg, cost nearly the same: the alternatives are kept.

    Parameters
    ----------
    source, target
    landmark
        Position in `source.samples`.
    config
        `partners` says how many.
    time
        Diffusion time at which partners must be apart.

    Returns
    -------
    (at most config.partners,) int64
        Positions in `target.samples`.
    """
    candidates = nearest_signatures(source.signature[landmark], target.signature, config.candidates)
    coordinates = source.among_samples(int(landmark))
    others = [target.among_samples(int(each)) for each in candidates]
    none = np.zeros((len(target.samples), len(source.samples)), dtype=np.float32)
    costs = candidate_costs(none, coordinates, others)
    embedding = diffusion_map(target.diffusion, time, target.samples)
    apart = PARTNERS_APART * np.sqrt(embedding.var(axis=0).sum())
    left = np.ones(len(candidates), dtype=bool)
    chosen: list[int] = []
    while left.any() and len(chosen) < config.partners:
        best = np.flatnonzero(left)[costs[left].argmin()]
        chosen.append(int(candidates[best]))
        gap = np.linalg.norm(embedding[candidates] - embedding[candidates[best]], axis=1)
        left &= gap > apart
    return np.array(chosen, dtype=np.int64)


def candidate_costs(agreement: Float32, coordinates: Float32, others: list[Float32]) -> Float64:
    """Objective of Eq. 16 for candidates.

    Parameters
    ----------
    agreement : (m, s)
        Squared distances from landmarks found before, of target samples from source samples.
    coordinates : (s, T)
        Of the source samples, from the new landmark.
    others : list of (m, T)
        Of the target samples, from each candidate.

    Returns
    -------
    (candidates,) float64
    """
    costs = np.empty(len(others))
    over_blocks(len(others), _candidate_costs(agreement, coordinates, others, costs), block=8)
    return costs


def _candidate_costs(
    agreement: Float32, coordinates: Float32, others: list[Float32], costs: Float64
) -> Callable[[slice], None]:
    """Task that writes the objective of Eq. 16 for a slice of the candidates."""

    def work(piece: slice) -> None:
        for c in range(piece.start, piece.stop):
            product, square_x, square_y = _square_parts(coordinates, others[c])
            costs[c] = _sum_of_nearest(agreement, product, square_x, square_y)

    return work


def nearest_signatures(
    signature: NDArray[np.float32], others: NDArray[np.float32], fraction: float
) -> NDArray[np.int64]:
    """The given fraction of the other samples, at least one, whose signatures are nearest; nearest first."""
    count = max(1, round(fraction * len(others)))
    return np.linalg.norm(others - signature, axis=1).argsort(kind="stable")[:count].astype(np.int64)


def _square_parts(x: Float32, y: Float32) -> tuple[Float32, Float32, Float32]:
    """Terms of |x_i - y_j|^2 = -2 y_j.x_i + |x_i|^2 + |y_j|^2, centred to keep digits; (m, n), (n,), (m,)."""
    centre = y.mean(axis=0)
    a, b = x - centre, y - centre
    return b @ (-2 * a.T), np.einsum("nd,nd->n", a, a), np.einsum("md,md->m", b, b)


@compiled()
def _sum_of_nearest(agreement: Float32, product: Float32, square_x: Float32, square_y: Float32) -> float:
    """Sum over columns of the square root of the column's smallest squared distance (Eq. 16's objective)."""
    least = np.full(len(square_x), np.float32(np.inf))
    for j in range(len(square_y)):
        for i in range(len(square_x)):  # columns side by side
            least[i] = min(least[i], agreement[j, i] + product[j, i] + square_y[j])
    total = 0.0
    for i in range(len(square_x)):
        total += np.sqrt(max(least[i] + square_x[i], np.float32(0)))
    return total
