"""Makes samples: a scan of one body, cut at a threshold, thinned out, with its place on the reference."""

import itertools
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen import Collection, InputError, Shape
from evaluation.experiment.config_sections import SURFACE
from evaluation.experiment.subject_plan import scanner_settings
from evaluation.generation.sample_plan import SampleIdentity, SamplePlan
from evaluation.generation.training_sample import TrainingSample
from evaluation.results.outcome import one_line
from evaluation.running.stages.threshold_scan import PROBES, lacking, moved, on_reference
from medial.validation import FEWEST_POINTS
from scanner_sim import Scan, ScannerConfig, coverage, sample, scan


@dataclass(frozen=True)
class FailedSample:
    """A sample that could not be made.

    Attributes
    ----------
    identity : SampleIdentity
    reason : str
        One line.
    refused : bool
        Whether it would be so again: nothing was acquired, for instance. Otherwise it was no fault of the
        sample, and is worth another try.
    """

    identity: SampleIdentity
    reason: str
    refused: bool


def samples_of(
    plan: SamplePlan, split: str, first: int, count: int, load: Callable[[str], Collection]
) -> Iterator[TrainingSample | FailedSample]:
    """Samples in their order; one that fails is told of, and the rest goes on.

    Parameters
    ----------
    plan
    split, first, count
        Which samples.
    load
        Name of a data set to its shapes.
    """
    identities = (plan.identity(split, index) for index in range(first, first + count))
    for _, group in itertools.groupby(identities, key=lambda each: each.render):
        yield from _of_render(plan, list(group), load)


def make_sample(
    plan: SamplePlan, split: str, index: int, load: Callable[[str], Collection]
) -> TrainingSample:
    """One sample alone: the same as in its shard.

    Raises
    ------
    InputError
        If it cannot be made.
    """
    (made,) = samples_of(plan, split, index, 1, load)
    if isinstance(made, FailedSample):
        raise InputError(f"sample {made.identity.key!r} cannot be made: {made.reason}")
    return made


def _of_render(
    plan: SamplePlan, group: list[SampleIdentity], load: Callable[[str], Collection]
) -> Iterable[TrainingSample | FailedSample]:
    """Samples that share what the scanner acquires."""
    try:
        collection = load(group[0].dataset)
        acquired = _acquired(plan, group[0], collection[group[0].pose])
    except Exception as error:
        return [_failed(identity, error) for identity in group]
    found: list[TrainingSample | FailedSample] = []
    for identity in group:
        try:
            found.append(_sample(identity, collection, acquired))
        except Exception as error:
            found.append(_failed(identity, error))
    return found


def _failed(identity: SampleIdentity, error: Exception) -> FailedSample:
    refused = isinstance(error, InputError)
    return FailedSample(identity, str(error) if refused else one_line(error), refused)


def _acquired(plan: SamplePlan, identity: SampleIdentity, shape: Shape) -> Scan | None:
    """All that the scanner sees, down to the lowest threshold; None for a mesh that is sampled as it is."""
    if identity.condition.views == SURFACE:
        return None
    lowest = replace(identity.condition, threshold=plan.config.draw.threshold[0])
    config = ScannerConfig.from_dict(scanner_settings(lowest))
    return scan(shape, config, seed=identity.render_seed)


def _sample(identity: SampleIdentity, collection: Collection, acquired: Scan | None) -> TrainingSample:
    shape, condition = collection[identity.pose], identity.condition
    if acquired is None:
        cloud, missing = sample(shape, condition.points, seed=identity.seed), lacking(collection, shape)
    else:
        accepted = acquired.accept(condition.threshold)
        if len(accepted) < FEWEST_POINTS:
            raise InputError(
                f"{len(accepted)} points of {shape.name!r} reach the peak threshold {condition.threshold}, "
                f"fewer than {FEWEST_POINTS}; lower it"
            )
        missing = 1 - coverage(accepted, shape, samples=PROBES)
        cloud = accepted.subsample(condition.points, seed=identity.seed)
    placed = on_reference(cloud, collection, shape)
    turn = {"rotation": condition.rotation, "scale": condition.scale, "seed": identity.seed}
    placed = moved(placed, turn)
    canonical = collection.reference.at(placed.face_ids, placed.barycentrics)
    return TrainingSample(
        key=identity.key,
        points=_single(placed.points),
        normals=_single(placed.normals),
        true_points=_single(placed.true_points),
        canonical=_single(canonical),
        face_ids=placed.face_ids.astype("<i4"),
        barycentrics=_single(placed.barycentrics),
        intensity=_single(placed.intensity),
        view_ids=placed.view_ids.astype("<i4"),
        about=_about(identity, collection, shape, len(placed), missing),
    )


def _single(array: NDArray[np.float64]) -> NDArray[np.float32]:
    return array.astype("<f4")


def _about(
    identity: SampleIdentity, collection: Collection, shape: Shape, points: int, missing: float
) -> dict[str, Any]:
    """What the JSON file of a sample says."""
    condition = identity.condition
    surface = condition.views == SURFACE
    return {
        "key": identity.key,
        "split": identity.split,
        "index": identity.index,
        "dataset": identity.dataset,
        "subject": collection.subject,
        "individual": identity.individual,
        "pose": identity.pose,
        "reference": collection.reference.pose,
        "units": shape.units,
        "held_out": identity.held_out,
        "threshold": None if surface else condition.threshold,
        "views": condition.views,
        "scanner": dict(condition.scanner),
        "rotation": condition.rotation,
        "scale": condition.scale,
        "seed": identity.seed,
        "render": identity.render,
        "render_seed": None if surface else identity.render_seed,
        "points": points,
        "missing": round(missing, 6),
    }
