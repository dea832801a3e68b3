"""Dense correspondences between two clouds from their diffusions (Sec. 4)."""

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError
from medial.diffusion import Diffusion
from medial.landmarks import Side, extend, landmark_order, prepare, search_landmarks, shared_times
from medial.matching_types import MatchConfig, Matching
from medial.nearest import single_blas_thread


def match(source: Diffusion, target: Diffusion, config: MatchConfig | None = None, seed: int = 0) -> Matching:
    """Match every source point to a target point.

    Parameters
    ----------
    source, target
        Diffusions of one kind of operator.
    config
        Defaults to `MatchConfig()`.
    seed
        Draws the samples and the first landmarks. The same seed gives the same result for any number of
        threads.

    Returns
    -------
    Matching

    Raises
    ------
    InputError
        If the operators differ, or a cloud has no positive eigenvalue.
    """
    config = config or MatchConfig()
    times, here, there = prepare_pair(source, target, config, seed)
    rng = np.random.default_rng([seed, 2])
    count = min(config.restarts, len(here.samples))
    starts = rng.choice(len(here.samples), size=count, replace=False)
    found = [_restart(here, there, times, int(start), config) for start in starts]
    costs = np.array([cost for _, cost in found])
    best = int(costs.argmin())
    landmarks = found[best][0]
    mapped, residual = extend(here, there, landmarks, slice(None))
    table = {
        "first": np.array([pairs[0, 0] for pairs, _ in found]),
        "partner": np.array([pairs[0, 1] for pairs, _ in found]),
        "cost": costs,
        "score": -costs,
        "chosen": np.arange(count) == best,
    }
    return Matching(
        source_to_target=mapped,
        landmarks=landmarks,
        cost=float(costs[best]),
        confidence=_confidence(residual),
        restarts=table,
        seed=seed,
        config=config,
    )


def extrapolate(
    source: Diffusion,
    target: Diffusion,
    landmarks: NDArray[np.integer],
    config: MatchConfig | None = None,
    seed: int = 0,
) -> Matching:
    """Grow a dense correspondence from given landmarks (Eq. 17).

    Parameters
    ----------
    source, target
    landmarks : (L, 2)
        Source and target point ids.
    config, seed
        As for `match`.

    Raises
    ------
    InputError
        If a landmark is not a point of its cloud.
    """
    config = config or MatchConfig()
    pairs = np.asarray(landmarks, dtype=np.int64).reshape(-1, 2)
    for column, diffusion, name in ((0, source, "source"), (1, target, "target")):
        if len(pairs) == 0 or pairs[:, column].min() < 0 or pairs[:, column].max() >= len(diffusion):
            raise InputError(
                f"landmarks need {name} point ids in [0, {len(diffusion)}), got {pairs[:, column].tolist()}"
            )
    _, here, there = prepare_pair(source, target, config, seed)
    mapped, residual = extend(here, there, pairs, slice(None))
    cost = float(residual[here.samples].mean())
    table = {
        "first": pairs[:1, 0],
        "partner": pairs[:1, 1],
        "cost": np.array([cost]),
        "score": np.array([-cost]),
        "chosen": np.array([True]),
    }
    return Matching(
        source_to_target=mapped,
        landmarks=pairs,
        cost=cost,
        confidence=_confidence(residual),
        restarts=table,
        seed=seed,
        config=config,
    )


def prepare_pair(
    source: Diffusion, target: Diffusion, config: MatchConfig, seed: int
) -> tuple[NDArray[np.float64], Side, Side]:
    """Shared times and the prepared clouds.

    Raises
    ------
    InputError
        If the operators differ: their diffusions cannot be compared.
    """
    if source.operator != target.operator:
        raise InputError(
            f"cannot match a {source.operator!r} diffusion to a {target.operator!r} one; use one operator"
        )
    times = shared_times(source, target, config)
    here = prepare(source, times, config, np.random.default_rng([seed, 0]))
    there = prepare(target, times, config, np.random.default_rng([seed, 1]))
    return times, here, there


def _restart(
    here: Side, there: Side, times: NDArray[np.float64], start: int, config: MatchConfig
) -> tuple[NDArray[np.int64], float]:
    """Landmarks (point ids) that grow from one first landmark, and the mean of Eq. 17 over the samples."""
    order = landmark_order(here, times, start, config.landmarks)
    with single_blas_thread():
        partners = search_landmarks(here, there, order, config)
    landmarks = np.column_stack([here.samples[order], there.samples[partners]])
    _, residual = extend(here, there, landmarks, here.samples)
    return landmarks, float(residual.mean())


def _confidence(residual: NDArray[np.float64]) -> NDArray[np.float64]:
    """Residuals of Eq. 17 relative to their median, mapped to [0, 1]: 1 fits perfectly, 1/2 is typical."""
    typical = max(float(np.median(residual)), np.finfo(float).tiny)
    return 1 / (1 + residual / typical)
