"""The built-in bodies by name: how each is made, in which poses and for which subjects."""

import logging
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

from datasets_gen.bodies import analytic, bird, hand, human, octopus, quadruped
from datasets_gen.bodies.analytic import AnalyticPlan
from datasets_gen.bodies.body_plan import BodyPlan
from datasets_gen.bodies.mesh_noise import STRONGEST, with_mesh_noise
from datasets_gen.bodies.subjects import Regions, build_subjects, numbered
from datasets_gen.cache import cache_path, fetch, store
from datasets_gen.collection import Collection
from datasets_gen.collections.file_choice import pose_list
from datasets_gen.fingerprints import seed_of
from datasets_gen.records import InputError
from datasets_gen.values import check_count, check_seed

_log = logging.getLogger(__name__)

MAKER = "datasets_gen.bodies.subjects"
"""Module that makes a body of its plan: with that of the plan, what the cache depends on."""
MOST_SUBJECTS = 100
MOST_VARIATION = 0.3
HELD_OUT_SEEDS = 100
"""Bodies of this seed and above are held out (`datasets_gen.registry.held_out`)."""


@dataclass(frozen=True)
class Recipe:
    """How a built-in body is made.

    Attributes
    ----------
    about : str
        One line for people.
    plan : callable
        From a seed to the plan.
    regions : callable or None
        What varies as one; None for the shapes of formulas.
    same_length : mapping
        As for `datasets_gen.bodies.proportions.random_scales`.
    held_out : bool
        Whether no constant of a method may be tuned on it.
    """

    about: str
    plan: Callable[[int], BodyPlan | AnalyticPlan]
    regions: Callable[[], Regions] | None = None
    same_length: Mapping[str, str] = field(default_factory=dict)
    held_out: bool = False


BODIES: dict[str, Recipe] = {
    "human": Recipe("an adult, symmetric", human.plan, human.regions),
    "human_asymmetric": Recipe(
        "the human with one arm, one leg, hair and a pouch that differ", human.asymmetric_plan, human.regions
    ),
    "quadruped": Recipe("a horse, symmetric", quadruped.plan, quadruped.regions, quadruped.SAME_LENGTH),
    "hand": Recipe("a right hand with its wrist", hand.plan, hand.regions, held_out=True),
    "bird": Recipe("a long-necked running bird, symmetric", bird.plan, bird.regions, held_out=True),
    "octopus": Recipe("an octopus, eight arms nearly alike", octopus.plan, octopus.regions, held_out=True),
    "capsule_chain": Recipe("a body of revolution, thick and thin in turn", analytic.capsule_chain),
    "dumbbell": Recipe("two unequal balls and a bar", analytic.dumbbell),
    "thin_sheet": Recipe("a thin sheet, rolled and folded", analytic.thin_sheet),
    "torus": Recipe("a ring, squeezed and folded", analytic.torus),
}


def load_body(
    name: str,
    *,
    seed: int = 0,
    poses: Sequence[str] | None = None,
    subjects: int = 1,
    variation: float = 0.1,
    mesh_noise: float = 0.0,
) -> Collection:
    """Poses of a built-in body; vertex i is the same place of the skin in every pose of every subject.

    Parameters
    ----------
    name
        One of `BODIES`.
    seed
        Proportions; 0 is the default body. Another seed of an articulated body has another mesh, too.
    poses
        Names, those of held-out poses among them; default all that are not held out.
    subjects
        How many bodies with one connectivity. With more than one, poses are called ``1-rest``, ``1-walk``,
        ..., ``2-rest``, the reference is ``1-rest``, and maps between subjects are not isometric.
    variation
        Largest relative change of lengths and girths from the first subject to the others.
    mesh_noise
        Largest shift of the vertices along the surface, as a share of the way to a neighbour; they are also
        numbered at random (`datasets_gen.bodies.mesh_noise`). 0 leaves the mesh as it was made.

    Raises
    ------
    InputError
        If an option is out of its range, or there is no such pose.
    """
    told = outline_body(
        name, seed=seed, poses=poses, subjects=subjects, variation=variation, mesh_noise=mesh_noise
    )
    recipe, several = BODIES[name], subjects > 1
    parameters = {"seed": int(seed)} | (
        {"subjects": int(subjects), "variation": variation} if several else {}
    )
    path = cache_path(name, parameters, recipe.plan.__module__, MAKER)
    collection = fetch(path)
    if collection is None:
        _log.info("building %r", told["subject"])
        others = [seed_of(name, int(seed), number) for number in range(1, int(subjects))]
        plan = recipe.plan(int(seed))
        collection = build_subjects(plan, recipe.regions, recipe.same_length, others, float(variation))
        store(path, collection)
    if mesh_noise:
        collection = with_mesh_noise(collection, float(mesh_noise), seed_of(name, int(seed), "mesh noise"))
    chosen = replace(collection, shapes=tuple(collection[pose] for pose in told["poses"]))
    return chosen if chosen.subject == told["subject"] else _renamed(chosen, told["subject"])


def outline_body(
    name: str,
    *,
    seed: int = 0,
    poses: Sequence[str] | None = None,
    subjects: int = 1,
    variation: float = 0.1,
    mesh_noise: float = 0.0,
) -> dict[str, Any]:
    """Subject, poses and reference that `load_body` would give.

    Parameters
    ----------
    name, seed, poses, subjects, variation, mesh_noise
        As for `load_body`.

    Returns
    -------
    dict
        ``subject`` (str), ``poses`` (list of str, in order), ``reference`` (str).

    Raises
    ------
    InputError
        As `load_body`.
    """
    check_seed(seed, f"seed of {name!r}")
    if check_count(subjects, f"subjects of {name!r}") > MOST_SUBJECTS:
        raise InputError(f"subjects of {name!r} is {subjects}; give at most {MOST_SUBJECTS}")
    _check_share(variation, f"variation of {name!r}", MOST_VARIATION)
    _check_share(mesh_noise, f"mesh_noise of {name!r}", STRONGEST)
    parts = [name, *([str(int(seed))] if seed else [])]
    if subjects > 1:
        parts += [f"{int(subjects)}subjects", f"variation{float(variation):g}"]
    parts += [f"noise{float(mesh_noise):g}"] if mesh_noise else []
    plan = BODIES[name].plan(0)
    default = numbered(plan.poses, int(subjects))
    known = [*default, *numbered(plan.held_out, int(subjects))]
    return {
        "subject": "-".join(parts),
        "poses": default if poses is None else pose_list(poses, known, name),
        "reference": default[0],
    }


def is_held_out(name: str, seed: int = 0, poses: Sequence[str] | None = None) -> bool:
    """Whether a built-in body is kept from tuning: its family, its seed, or one of the poses."""
    recipe = BODIES[name]
    kept = recipe.plan(0).held_out
    asked = {pose.rpartition("-")[2] for pose in poses or ()}
    return recipe.held_out or seed >= HELD_OUT_SEEDS or bool(asked & {*kept})


def _check_share(value: float, name: str, most: float) -> None:
    if not 0 <= value <= most:
        raise InputError(f"{name} is {value!r}; give a number from 0 to {most:g}")


def _renamed(collection: Collection, subject: str) -> Collection:
    """The collection and its shapes under the name of a subject."""
    found = {
        each.pose: replace(each, name=f"{subject}/{each.pose}", subject=subject)
        for each in (collection.reference, *collection.shapes)
    }
    shapes = tuple(found[pose] for pose in collection.poses)
    return replace(collection, subject=subject, shapes=shapes, reference=found[collection.reference.pose])
