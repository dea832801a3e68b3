"""Poses of the bird: (flexion, twist, swing) in degrees of the bones that turn.

Positive flexion lowers the front of the trunk and bends the neck forward, lifts the tail, swings a thigh
forward, closes knee, ankle and toes, and lifts a wing; positive swing of a thigh spreads the leg.
"""

from datasets_gen.bodies.skeleton import Angles, Limits, Pose

FIXED = (0.0, 0.0)
NECK = tuple(f"neck_{k}" for k in range(1, 6))

LIMITS: Limits = {
    **dict.fromkeys(NECK, ((-48, 48), (-25, 25), (-40, 40))),
    "head": ((-45, 75), (-30, 30), (-40, 40)),
    "tail": ((-25, 40), (-15, 15), (-25, 25)),
    "thigh": ((-35, 50), (-15, 15), (-10, 20)),
    "shin": ((-30, 65), FIXED, FIXED),
    "foot": ((-35, 110), FIXED, FIXED),
    "toes": ((-70, 60), FIXED, FIXED),
    "wing": ((-15, 75), (-30, 30), (-30, 50)),
    "wing_tip": ((-30, 60), (-20, 20), (-20, 50)),
}
"""Ranges of motion about the rest pose, degrees: of the legs as measured in running ostriches [RSM11].

[RSM11] J. Rubenson et al., "Adaptations for economical bipedal running", J. R. Soc. Interface 8, 2011.
"""


def leg(
    side: str,
    thigh: float,
    shin: float,
    foot: float,
    toes: float | None = None,
    spread: float = 0,
    trunk: float = 0,
) -> dict[str, Angles]:
    """Angles of one leg; by default the toes stay level, given the flexion of the trunk."""
    level = thigh - shin + foot - trunk
    return {
        f"thigh.{side}": (thigh, 0, spread), f"shin.{side}": (shin, 0, 0), f"foot.{side}": (foot, 0, 0),
        f"toes.{side}": (level if toes is None else toes, 0, 0),
    }  # fmt: skip


def neck(*flexions: float, swing: float = 0, twist: float = 0) -> dict[str, Angles]:
    """Flexion of each bone of the neck from the chest; swing and twist are the same for all."""
    return {name: (angle, twist, swing) for name, angle in zip(NECK, flexions, strict=True)}


def wings(lift: float, back: float = 0, tip: float = 0) -> dict[str, Angles]:
    """Both wings alike."""
    both: dict[str, Angles] = {}
    for side in "LR":
        both |= {f"wing.{side}": (lift, 0, back), f"wing_tip.{side}": (tip, 0, 0)}
    return both


POSES: dict[str, Pose] = {
    "stand": {},
    "walk": {**leg("L", 16, 4, 0), **leg("R", -12, -8, 10, -14), **neck(4, 4, 0, -4, -4), "tail": (4, 0, 0)},
    "run": {
        **leg("L", 34, 30, 46, 30), **leg("R", -22, -18, -14, -40), **neck(14, 8, -2, -8, -10),
        **wings(18, 0, 10), "trunk": (4, 0, 0), "tail": (10, 0, 0),
    },
    "peck": {
        **neck(46, 40, 26, 8, -8), "head": (-38, 0, 0), "trunk": (26, 0, 0), **leg("L", 34, 8, 0, trunk=26),
        **leg("R", 22, -4, 0, trunk=26), "tail": (12, 0, 0),
    },
    "look_back": {
        **neck(-4, -2, 4, 4, 2, swing=24), "head": (4, 0, 24), "tail": (4, 0, 10),
    },
    "display": {
        **wings(62, -8, -16), **neck(26, 10, -22, -34, -22), "head": (20, 0, 0), "trunk": (8, 0, 0),
        **leg("L", 14, 6, 0, trunk=8), **leg("R", 8, 0, 0, trunk=8), "tail": (30, 0, 0),
    },
    "one_leg": {
        **leg("L", 34, 46, 92, 40), **leg("R", 0, 0, 0, 0, 4), **neck(-10, -14, -4, 12, 22),
        "head": (14, 0, 0), "tail": (-6, 0, 0),
    },
    "alert": {
        **neck(-22, -18, 4, 14, 12), "head": (6, 0, 18), **leg("L", 6, -6, -8, trunk=-10),
        **leg("R", -4, -6, 0, trunk=-10), "trunk": (-10, 0, 0), "tail": (-8, 0, 0),
    },
    "crouch": {
        **leg("L", 36, 46, 68, None, 6), **leg("R", 30, 42, 70, None, 6), **neck(30, 22, 4, -18, -30),
        "head": (-8, 0, 0), "trunk": (6, 0, 0), **wings(8),
    },
    "kick": {
        **leg("L", 24, -24, 0, 10), **leg("R", -8, 6, 16, trunk=-14), "trunk": (-14, 0, 0),
        **neck(-14, -6, 6, 10, 8), **wings(40, 0, 4), "tail": (-8, 0, 0),
    },
}  # fmt: skip
