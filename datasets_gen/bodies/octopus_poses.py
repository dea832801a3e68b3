"""Poses of the octopus: (flexion, twist, swing) in degrees of the bones that turn.

Arms are numbered from the front around the left; each has `BONES` bones from the root to the tip. Positive
flexion curls an arm down, to the side of the mouth; positive swing bends it around the body.
"""

from collections.abc import Sequence

from datasets_gen.bodies.skeleton import Angles, Limits, Pose

ARMS, BONES = 8, 8
ARM_RANGE = ((-42.0, 42.0), (-20.0, 20.0), (-42.0, 42.0))


def arm_bone(number: int, bone: int) -> str:
    """Name of a bone; both numbers from 1."""
    return f"arm{number}_{bone}"


LIMITS: Limits = {
    "mantle": ((-35, 35), (-20, 20), (-30, 30)),
    **{arm_bone(n, k): ARM_RANGE for n in range(1, ARMS + 1) for k in range(1, BONES + 1)},
}
"""An arm of an octopus can bend anywhere; more than this at one joint would fold it."""


def arm(number: int, flexion: Sequence[float], swing: Sequence[float] = ()) -> dict[str, Angles]:
    """Angles of one arm from root to tip; missing ones are those of the last given, or 0."""
    found: dict[str, Angles] = {}
    for k in range(BONES):
        bend, turn = ((each[min(k, len(each) - 1)] if each else 0.0) for each in (flexion, swing))
        found[arm_bone(number, k + 1)] = (bend, 0, turn)
    return found


def arms(
    flexion: Sequence[float], swing: Sequence[float] = (), which: Sequence[int] = range(1, ARMS + 1)
) -> dict[str, Angles]:
    """The same angles for several arms."""
    found: dict[str, Angles] = {}
    for number in which:
        found |= arm(number, flexion, swing)
    return found


UP_AND_DOWN = (-40, -26, -6, 16, 28, 30, 24, 14)
CURL = (0, 0, -6, -16, -28, -36, -40, -40)

POSES: dict[str, Pose] = {
    "rest": {},
    "curl": {**arms(CURL), "mantle": (8, 0, 0)},
    "pinwheel": {**arms((-4, 2, 2, 0), (6, 16, 18, 18, 18, 18, 18, 18)), "mantle": (0, 0, 12)},
    "stride": {
        **arms((-22, -4, 12, 16, 10, 4, -2, -4), (6, 4, 0), (1, 4, 6)),
        **arms((-4, -6, 4, 8, 2, 0), (-4, -5, -4, 4, 6, 6, 4, 2), (2, 5, 7)),
        **arms((6, 0, -4, -8, -12, -16, -18, -20), (0, 4, 4, 4), (3, 8)), "mantle": (-10, 0, 6),
    },
    "reach": {
        **arm(1, (-38, -16, -4, 4, 6, 4, 2, 2), (-4, -4, -2, 2)),
        **arm(8, (-30, -10, 4, 10, 8, 4), (6, 4, 0)),
        **arms((-2, 2, 2, 0), (8, 14, 14, 10, 6, -6, -14, -20), (2, 3, 4)),
        **arms((-2, 2, 2, 0), (-8, -14, -14, -10, -4, 8, 16, 22), (5, 6, 7)), "mantle": (-14, 0, 0),
    },
    "swim": {**arms((34, 14, 2, -2, -4, -4, -4, -4), (0, 0, 2, 2)), "mantle": (20, 0, 0)},
    "umbrella": {**arms(UP_AND_DOWN), "mantle": (-6, 0, 0)},
    "wave": {
        **arms((-4, -10, 6, 16, 4, -14, -10, 8), (0, 12, 20, 8, -16, -24, -12, 10), (1, 3, 5, 7)),
        **arms((0, 6, 4, -10, -14, 0, 10, 12), (0, -14, -16, -2, 16, 22, 12, -4), (2, 4, 6, 8)),
        "mantle": (10, 0, -14),
    },
    "defend": {
        **arms((-40, -30, -14, -2, 8, 14, 20, 24), (), (1, 2, 7, 8)), **arms((-6, 2, 4, 0), (), (3, 4, 5, 6)),
        "mantle": (24, 0, 0),
    },
}  # fmt: skip
