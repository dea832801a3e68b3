"""Poses of the human: (flexion, twist, swing) in degrees of the bones that turn.

Positive flexion bends the trunk forward, lifts arms and thighs to the front and closes elbows and knees;
positive swing lifts an arm or a leg to its side; positive twist of the trunk turns it to the left.
"""

from datasets_gen.bodies.skeleton import Angles, Pose


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
