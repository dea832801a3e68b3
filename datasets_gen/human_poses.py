"""Poses of the human: (flexion, twist, swing) in degrees of the bones that turn."""

from datasets_gen.skeleton import Angles, Pose


def both(**angles: Angles) -> dict[str, Angles]:
    """The same angles for the bones of both sides."""
    return {f"{name}.{side}": value for name, value in angles.items() for side in "LR"}


POSES: dict[str, Pose] = {
    "rest": {},
    "tpose": both(upper_arm=(0, 0, 46)),
    "arms_up": both(clavicle=(20, 0, 0), upper_arm=(0, 0, 108), forearm=(15, 0, 0)),
    "walk": {
        "upper_arm.L": (-25, 0, -34), "upper_arm.R": (25, 0, -34), "forearm.L": (15, 0, 0), "forearm.R": (30, 0, 0),
        "thigh.L": (28, 0, 0), "shin.L": (12, 0, 0), "thigh.R": (-18, 0, 0), "shin.R": (25, 0, 0), "foot.R": (-10, 0, 0),
    },
    "sit": both(upper_arm=(30, 0, -34), forearm=(40, 0, 0), thigh=(85, 0, 4), shin=(85, 0, 0)),
    "bend": {**both(upper_arm=(60, 0, -30), thigh=(20, 0, 0)), "pelvis": (20, 0, 0), "waist": (18, 0, 0), "ribs": (18, 0, 0),
             "chest": (14, 0, 0)},
    "twist": {"waist": (0, 15, 0), "ribs": (0, 18, 0), "chest": (0, 18, 0), "neck": (0, 15, 0), "head": (0, 15, 0),
              "upper_arm.R": (70, 0, -20), "forearm.R": (40, 0, 0)},
    "lunge": {"thigh.L": (75, 0, 6), "shin.L": (80, 0, 0), "thigh.R": (-30, 0, 4), "shin.R": (35, 0, 0),
              "foot.R": (10, 0, 0), "upper_arm.L": (10, 0, 30), "upper_arm.R": (95, 0, -20)},
}  # fmt: skip
