"""Poses of the human: (flexion, twist, swing) in degrees of the bones that turn.

Positive flexion bends the trunk forward, lifts arms and thighs to the front and closes elbows and knees;
positive swing lifts an arm or a leg to its side; positive twist of the trunk turns it to the left.
"""

from datasets_gen.bodies.skeleton import Angles, Limits, Pose

FIXED = (0.0, 0.0)
SPINE = ((-15.0, 30.0), (-20.0, 20.0), (-12.0, 12.0))

LIMITS: Limits = {
    "waist": SPINE, "ribs": SPINE, "chest": SPINE,
    "neck": ((-40, 35), (-40, 40), (-25, 25)), "head": ((-30, 25), (-40, 40), (-20, 20)),
    "clavicle": ((-10, 35), FIXED, FIXED), "upper_arm": ((-60, 170), (-90, 90), (-55, 135)),
    "forearm": ((0, 145), FIXED, FIXED), "hand": ((-70, 75), FIXED, FIXED),
    "thigh": ((-30, 120), (-45, 45), (-25, 45)), "shin": ((0, 145), FIXED, FIXED),
    "foot": ((-50, 25), FIXED, FIXED), "toes": ((-30, 60), FIXED, FIXED),
}  # fmt: skip
"""Ranges of motion about the rest pose, in which the arms hang 46 degrees below the level, as in goniometry
[NW16]. The spine's share is that of each of its three bones.

[NW16] C. C. Norkin, D. J. White, "Measurement of joint motion: a guide to goniometry", 5th ed., 2016.
"""


def both(**angles: Angles) -> dict[str, Angles]:
    """The same angles for the bones of both sides."""
    return {f"{name}.{side}": value for name, value in angles.items() for side in "LR"}


def trunk(flexion: float = 0, twist: float = 0, swing: float = 0) -> dict[str, Angles]:
    """Angles spread over waist, ribs and chest."""
    return dict.fromkeys(("waist", "ribs", "chest"), (flexion / 3, twist / 3, swing / 3))


def arm(
    side: str, flexion: float, swing: float, elbow: float, twist: float = 0, wrist: float = 0
) -> dict[str, Angles]:
    """Angles of one arm; swing -40 hangs it down, 46 holds it level."""
    return {
        f"upper_arm.{side}": (flexion, twist, swing), f"forearm.{side}": (elbow, 0, 0),
        f"hand.{side}": (wrist, 0, 0),
    }  # fmt: skip


def leg(
    side: str, flexion: float, knee: float, ankle: float = 0, swing: float = 0, twist: float = 0
) -> dict[str, Angles]:
    """Angles of one leg."""
    return {
        f"thigh.{side}": (flexion, twist, swing),
        f"shin.{side}": (knee, 0, 0),
        f"foot.{side}": (ankle, 0, 0),
    }


POSES: dict[str, Pose] = {
    "rest": {},
    "tpose": both(upper_arm=(0, 0, 46)),
    "arms_up": {**both(clavicle=(20, 0, 0), upper_arm=(0, 0, 100), forearm=(18, 0, 0)), "head": (-12, 0, 0)},
    "walk": {
        **arm("L", -26, -33, 16), **arm("R", 24, -33, 28), **leg("L", 27, 10, 4), **leg("R", -16, 24, -8),
        "toes.R": (16, 0, 0), **trunk(3, 8), "pelvis": (0, -4, 0),
    },
    "run": {
        **arm("L", -48, -28, 85), **arm("R", 40, -30, 88), **leg("L", 62, 78, 6), **leg("R", -22, 62, -22),
        **trunk(9, 12), "pelvis": (8, -5, 0), "head": (-8, 0, 0),
    },
    "sit": {
        **arm("L", 26, -34, 44), **arm("R", 30, -34, 38), **both(thigh=(82, 0, 5), shin=(82, 0, 0)),
        **trunk(4),
    },
    "crouch": {
        **arm("L", 58, -16, 38), **arm("R", 52, -14, 46),
        **both(thigh=(85, -12, 20), shin=(96, 0, 0), foot=(14, 0, 0)), **trunk(18), "pelvis": (12, 0, 0),
        "neck": (-12, 0, 0), "head": (-12, 0, 0),
    },
    "bend": {
        **arm("L", 78, -30, 6), **arm("R", 70, -30, 8), **both(thigh=(26, 0, 0), shin=(6, 0, 0)),
        "pelvis": (28, 0, 0), **trunk(54), "neck": (-8, 0, 0),
    },
    "twist": {
        "pelvis": (0, 8, 0), **trunk(4, 48), "neck": (0, 12, 0), "head": (0, 16, 0), **arm("R", 68, -22, 58),
        **arm("L", -24, 18, 24), **both(thigh=(0, -6, 6)),
    },
    "lunge": {
        **leg("L", 72, 76, 2, 4), **leg("R", -28, 34, 8, 4), "toes.R": (30, 0, 0), **arm("L", 14, 34, 8),
        **arm("R", 92, -24, 10), "pelvis": (6, 0, 0), **trunk(6, -6),
    },
    "kick": {
        **leg("R", 74, 12, -18, 2), **leg("L", -4, 12, 4, 4), "pelvis": (-8, 0, 0), **trunk(8, 10),
        **arm("L", 50, -10, 42), **arm("R", -34, 10, 30),
    },
    "wave": {
        **arm("L", 20, 40, 84, -72), **arm("R", 8, -30, 62, 36), "clavicle.L": (10, 0, 0), **trunk(0, 0, 8),
        "head": (0, 8, 6),
    },
}  # fmt: skip

HELD_OUT: dict[str, Pose] = {
    "kneel": {
        **leg("L", 78, 82, 4, 6), **leg("R", -4, 88, -34, 4), "toes.R": (40, 0, 0), **arm("L", 44, -26, 34),
        **arm("R", 10, -34, 22), **trunk(8, -6), "head": (-6, 10, 0),
    },
    "throw": {
        **arm("R", -30, 62, 78, 30), **arm("L", 78, -6, 16), **leg("L", 34, 18, -2, 8),
        **leg("R", -20, 14, 2, 8), **trunk(-8, -26), "clavicle.R": (12, 0, 0), "head": (0, 18, 0),
    },
    "climb": {
        **arm("L", 135, -18, 14), **arm("R", 84, -24, 66), **leg("R", 78, 82, -4, 14),
        **leg("L", 6, 10, -12, 6), "clavicle.L": (22, 0, 0), **trunk(6, 0, 4), "head": (-18, 0, 0),
    },
}  # fmt: skip
"""Poses that are built where they are asked for by name, on which nothing was tuned."""
