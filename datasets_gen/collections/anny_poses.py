"""Poses of the `anny` human: those of the built-in human carried over to its bones, and further ones.

Angles are (flexion, twist, swing) in degrees as in `datasets_gen.bodies.human_poses`. At rest both have their
arms some 46 degrees below the horizontal; the elbows of this one are bent by `ELBOW` then, which is taken off
all other poses.
"""

from datasets_gen.bodies.human_poses import FIXED, arm, both, leg, trunk
from datasets_gen.bodies.human_poses import LIMITS as HUMAN_LIMITS
from datasets_gen.bodies.human_poses import POSES as HUMAN_POSES
from datasets_gen.bodies.skeleton import Angles, Limits, Pose, Range

ELBOW = 40.0
"""Flexion of the elbows at rest, degrees."""

BONES: dict[str, tuple[str, ...]] = {
    "pelvis": ("root",),
    "waist": ("spine05", "spine04"),
    "ribs": ("spine03",),
    "chest": ("spine02", "spine01"),
    "neck": ("neck01", "neck02", "neck03"),
    "upper_arm": ("upperarm01",),
    "forearm": ("lowerarm01",),
    "hand": ("wrist",),
    "thigh": ("upperleg01",),
    "shin": ("lowerleg01",),
}
"""Bones that together do what a bone of the built-in human does; the others have its name."""

TOES = tuple(f"toe{k}-1" for k in range(1, 6))
FINGERS = tuple(f"finger{k}-{joint}" for k in range(2, 6) for joint in range(1, 4))


def _shared(ranges: tuple[Range, Range, Range], bones: int) -> tuple[Range, Range, Range]:
    """The part of each of some bones of what they turn together."""
    flexion, twist, swing = ((low / bones, high / bones) for low, high in ranges)
    return flexion, twist, swing


LIMITS: Limits = {
    **{
        bone: _shared(HUMAN_LIMITS[stem], len(bones))
        for stem, bones in BONES.items() if stem in HUMAN_LIMITS for bone in bones
    },
    **{stem: HUMAN_LIMITS[stem] for stem in ("head", "clavicle", "foot")},
    **dict.fromkeys(TOES, HUMAN_LIMITS["toes"]),
    **dict.fromkeys(FINGERS, ((-20, 95), FIXED, FIXED)),
    "lowerarm01": ((-ELBOW, 145 - ELBOW), FIXED, FIXED),
}  # fmt: skip
"""Those of the built-in human, shared as its angles are; the root may turn freely."""


def carried(pose: Pose) -> Pose:
    """A pose of the built-in human for the bones of this one.

    Bones that stand for one of the human share its angles evenly.
    """
    found: dict[str, Angles] = {}
    for name, (flexion, twist, swing) in pose.items():
        stem, dot, side = name.partition(".")
        if stem == "toes":
            found |= {f"{toe}.{side}": (flexion, twist, swing) for toe in TOES}
            continue
        bones = BONES.get(stem, (stem,))
        part = (flexion / len(bones), twist / len(bones), swing / len(bones))
        found |= {f"{bone}{dot}{side}": part for bone in bones}
    for side in "LR":
        flexion, twist, swing = found.get(f"lowerarm01.{side}", (0.0, 0.0, 0.0))
        found[f"lowerarm01.{side}"] = (flexion - ELBOW, twist, swing)
    return found


def curl(side: str, angle: float) -> Pose:
    """Fingers bent by an angle at each joint."""
    return {f"{finger}.{side}": (angle, 0.0, 0.0) for finger in FINGERS}


FURTHER: dict[str, Pose] = {
    "reach": {
        **arm("L", 150, -10, 14), **arm("R", -18, -36, 18), "clavicle.L": (18, 0, 0), **trunk(-4, -6, 8),
        **leg("L", -6, 4, -14), **leg("R", 8, 12, -16), "head": (-14, 8, 0), "neck": (-8, 6, 0),
    },
    "carry": {
        **arm("L", 34, -34, 78), **arm("R", 34, -34, 78), **leg("L", 20, 16), **leg("R", -10, 18, -4),
        **trunk(-8), "head": (6, 0, 0),
    },
    "kneel": {
        **leg("L", 84, 88, 4, 6), **leg("R", 2, 92, -38, 4), "toes.R": (30, 0, 0), **trunk(10, 6),
        **arm("L", 46, -34, 36), **arm("R", 6, -34, 34), "head": (10, 0, 0),
    },
    "throw": {
        **arm("R", -10, 34, 88, -58), **arm("L", 88, -6, 12), **leg("L", 34, 14, 4, 6),
        **leg("R", -18, 24, 4, 8), "clavicle.R": (8, 0, 0), "pelvis": (0, -14, 0), **trunk(-6, -28),
        "neck": (0, 18, 0), "head": (0, 20, 0),
    },
    "hug": {
        **both(upper_arm=(84, -10, -24), forearm=(52, 0, 0)), **trunk(12), "head": (10, 8, 0),
        **leg("L", 4, 4, 0, 4), **leg("R", 2, 6, 0, 4),
    },
}  # fmt: skip

POSES: dict[str, Pose] = {
    name: carried(pose) if name != "rest" else {} for name, pose in (HUMAN_POSES | FURTHER).items()
}
for _name, _angle in (("run", 55.0), ("kick", 25.0), ("carry", 40.0), ("throw", 45.0)):
    POSES[_name] = {**POSES[_name], **curl("L", _angle), **curl("R", _angle)}
