"""Several subjects with one connectivity, in all poses of a plan: truth across subjects by vertex order."""

from collections.abc import Callable, Iterable, Mapping, Sequence

import numpy as np
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from datasets_gen.bodies.analytic import AnalyticPlan, varied
from datasets_gen.bodies.body_plan import BodyPlan, Skin, collection_of
from datasets_gen.bodies.proportions import Region, random_scales, varied_skin
from datasets_gen.collection import Collection

Array = NDArray[np.float64]
Regions = Mapping[str, Region]


def numbered(poses: Iterable[str], subjects: int) -> list[str]:
    """Names of the poses of all subjects: of one as they are, else ``1-rest``, ..., ``2-rest``, ..."""
    if subjects == 1:
        return list(poses)
    return [f"{number + 1}-{pose}" for number in range(subjects) for pose in poses]


@threadpool_limits.wrap(limits=1, user_api="blas")  # the last bits of a product depend on the threads
def build_subjects(
    plan: BodyPlan | AnalyticPlan,
    regions: Callable[[], Regions] | None = None,
    same_length: Mapping[str, str] | None = None,
    others: Sequence[int] = (),
    variation: float = 0.0,
) -> Collection:
    """Mesh a plan and pose it, and others of its kind with the same mesh; held-out poses are among them.

    Parameters
    ----------
    plan
        Of the first subject.
    regions
        What varies as one; None for shapes of formulas, which vary by `datasets_gen.bodies.analytic.varied`.
        Those of the default body serve all seeds: their anchors are within a few centimetres of the joints.
    same_length
        As for `random_scales`.
    others
        Seeds of the other subjects.
    variation
        Largest relative change of lengths and girths from the first subject to another.
    """
    if isinstance(plan, AnalyticPlan):
        rest, faces = plan.rest()
        mirror = None
        posed = [plan.posed(each) for each in (rest, *(varied(rest, other, variation) for other in others))]
    else:
        skin = Skin.of_plan(plan)
        faces, mirror = skin.faces, skin.mirror
        poses = {**plan.poses, **plan.held_out}
        posed = [skin.posed(poses)]
        spread, parts = (1 - variation, 1 + variation), regions() if regions else {}
        for other in others:
            scales = random_scales(parts, other, lengths=spread, girths=spread, same_length=same_length)
            posed.append(varied_skin(skin, parts, scales).posed(poses))
    vertices = [each for subject in posed for each in subject.values()]
    names = numbered(posed[0], len(posed))
    return collection_of(plan.name, faces, dict(zip(names, vertices, strict=True)), mirror)
