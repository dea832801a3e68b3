"""Poses of the dog and the rodent: angles of the joints of their models, in degrees.

Extending (positive) moves a hanging leg backward, lifts the rear of the back and the tail, and lowers the
head; knees, hocks and elbows bend by negative angles, the wrists of the dog, too. Bending (positive) turns
the head to the left and the rear of the back to the right.
"""

from collections.abc import Mapping

JointAngles = Mapping[str, float]


def dog_fore(
    side: str, scapula: float = 0, shoulder: float = 0, elbow: float = 0, wrist: float = 0, spread: float = 0
) -> dict[str, float]:
    """Angles of a fore leg of the dog."""
    return {
        f"scapula_{side}_extend": scapula, f"shoulder_{side}_extend": shoulder, f"elbow_{side}": elbow,
        f"wrist_{side}": wrist, f"scapula_{side}_abduct": spread,
    }  # fmt: skip


def hind(
    side: str, hip: float = 0, knee: float = 0, ankle: float = 0, toe: float = 0, abduct: float = 0
) -> dict[str, float]:
    """Angles of a hind leg of either animal."""
    return {
        f"hip_{side}_extend": hip, f"knee_{side}": knee, f"ankle_{side}": ankle, f"toe_{side}": toe,
        f"hip_{side}_abduct": abduct,
    }  # fmt: skip


def dog_back(extend: float = 0, bend: float = 0, twist: float = 0) -> dict[str, float]:
    """Angles of the dog's back, shared by its joints."""
    return {
        **{f"L_{k}_extend": extend / 4 for k in (1, 3, 5, 7)},
        **{f"L_{k}_bend": bend / 4 for k in (1, 3, 5, 7)},
        **{f"L_{k}_twist": twist / 3 for k in (2, 4, 6)},
    }  # fmt: skip


def dog_neck(extend: float = 0, bend: float = 0, twist: float = 0, nose: float = 0) -> dict[str, float]:
    """Angles of the dog's neck, shared by its joints, and of the head; positive `nose` lifts it."""
    return {
        **{f"C_{k}_extend": extend / 4 for k in (7, 5, 3, 1)},
        **{f"C_{k}_bend": bend / 4 for k in (7, 5, 3, 1)},
        **{f"C_{k}_twist": twist / 3 for k in (6, 4, 2)}, "atlas": nose,
    }  # fmt: skip


def dog_tail(lift: float = 0, bend: float = 0, root: float | None = None) -> dict[str, float]:
    """Angles of the dog's tail, each joint by the same, or the first ones by `root`."""
    lifts = {k: lift if root is None or k > 9 else root for k in range(1, 22, 2)}
    return {f"Ca_{k}_extend": angle for k, angle in lifts.items()} | {
        f"Ca_{k}_bend": bend for k in range(2, 21, 2)
    }


DOG: dict[str, JointAngles] = {
    "stand": {},
    "trot": {
        **dog_fore("L", -18, -22, 4), **dog_fore("R", 16, 22, -42, -40), **hind("R", -28, -14, -16),
        **hind("L", 24, -8, 6, 20), **dog_tail(3), **dog_neck(10),
    },
    "trot_other": {
        **dog_fore("R", -18, -22, 4), **dog_fore("L", 16, 22, -42, -40), **hind("L", -28, -14, -16),
        **hind("R", 24, -8, 6, 20), **dog_tail(3, 3), **dog_neck(10),
    },
    "gallop_extended": {
        **dog_fore("L", -28, -32, 14, 0, 6), **dog_fore("R", -24, -26, 6, 0, 6), **hind("L", 34, 2, 12, 30),
        **hind("R", 40, 0, 12, 35), **dog_back(6), **dog_neck(20, nose=10), **dog_tail(3),
    },
    "gallop_gathered": {
        **dog_fore("L", 24, 34, -26, -50, 4), **dog_fore("R", 20, 38, -38, -60, 6),
        **hind("L", -50, -20, -14, 0, 5), **hind("R", -40, -24, -18, 0, 5), **dog_back(-48),
        **dog_neck(30), **dog_tail(2),
    },
    "sit": {
        **dog_fore("L", 14, 32, -6), **dog_fore("R", 14, 32, -6), **hind("L", -56, -84, -84, 10, 4),
        **hind("R", -56, -84, -84, 10, 4), **dog_back(-24), **dog_neck(36, nose=-8),
        **dog_tail(6, 4, root=15),
    },
    "crouch": {
        **dog_fore("L", 0, 44, -84, -6, 16), **dog_fore("R", 0, 44, -84, -6, 16),
        **hind("L", -54, -86, -72, 0, 5), **hind("R", -54, -86, -72, 0, 5), **dog_back(-16),
        **dog_neck(0), **dog_tail(0, 5),
    },
    "sniff": {
        **dog_fore("L", -12, 6, -6), **dog_fore("R", 12, 10, -14), **hind("L", -10, -12, -10),
        **hind("R", 8, -4, 0), **dog_neck(128, nose=20), **dog_tail(5),
    },
    "turn": {
        **dog_fore("L", -8, -8, 0), **dog_fore("R", 10, 6, -8), **hind("L", -10, -6, -4),
        **hind("R", 12, -6, 4), **dog_back(0, -60, 10), **dog_neck(20, 90), **dog_tail(4, -7),
    },
    "stretch": {
        **dog_fore("L", -28, -30, 16, 0, 12), **dog_fore("R", -28, -36, 22, 0, 12), **hind("L", -26, 4, 2),
        **hind("R", -22, 4, 2), **dog_back(12), **dog_neck(-20, nose=10), **dog_tail(6),
    },
    "rear_up": {
        **dog_fore("L", -10, -12, -60, -60), **dog_fore("R", -10, -18, -50, -60), **hind("L", 24, -8, 2, 10),
        **hind("R", 34, -6, 6, 20), **dog_back(-10), **dog_neck(50), **dog_tail(4, 0, root=12),
    },
    "mark": {
        **hind("L", -34, -50, -30, 0, 64), **hind("R", 4, -6, -2), **dog_back(0, 16, -10),
        **dog_neck(10, -40), **dog_tail(8, 3), **dog_fore("L", -4), **dog_fore("R", 4),
    },
}  # fmt: skip

DOG_PITCH = {"sit": 40.0, "stretch": -24.0, "rear_up": 52.0}
"""How far the chest is lifted, degrees."""

RODENT_BACK = {"extend": (1, 4), "bend": (2, 5), "twist": (3, 6)}


def rodent_fore(
    side: str, shoulder: float = 0, elbow: float = 0, wrist: float = 0, finger: float = 0, turn: float = 0
) -> dict[str, float]:
    """Angles of a fore leg of the rodent."""
    return {
        f"shoulder_{side}": shoulder, f"elbow_{side}": elbow, f"wrist_{side}": wrist,
        f"finger_{side}": finger, f"shoulder_sup_{side}": turn,
    }  # fmt: skip


def rodent_back(extend: float = 0, bend: float = 0, twist: float = 0) -> dict[str, float]:
    """Angles of the rodent's back, shared by its joints."""
    shares = {"extend": extend / 2, "bend": bend / 2, "twist": twist / 2}
    return {f"vertebra_{k}_{kind}": shares[kind] for kind, joints in RODENT_BACK.items() for k in joints}


def rodent_neck(extend: float = 0, bend: float = 0, nose: float = 0) -> dict[str, float]:
    """Angles of the rodent's neck, shared by its joints, and of the head; positive `nose` lifts it."""
    return {
        "vertebra_cervical_5_extend": extend / 3, "vertebra_cervical_2_extend": extend / 3,
        "vertebra_atlant_extend": extend / 3, "vertebra_cervical_4_bend": bend / 2,
        "vertebra_cervical_1_bend": bend / 2, "atlas": nose,
    }  # fmt: skip


def rodent_tail(lift: float = 0, bend: float = 0) -> dict[str, float]:
    """Angles of the rodent's tail, each joint by the same."""
    lifts = (1, 2, 3, 4, 5, 6, 7, 11, 15, 19, 23, 27)
    bends = (1, 2, 3, 4, 5, 6, 9, 13, 17, 21, 25, 29)
    return {f"vertebra_C{k}_extend": lift for k in lifts} | {f"vertebra_C{k}_bend": bend for k in bends}


RODENT: dict[str, JointAngles] = {
    "stand": {},
    "walk": {
        **rodent_fore("L", -34, 12), **rodent_fore("R", 26, -16, 30, 30), **hind("L", 14, 6, 12, 20),
        **hind("R", -20, -14, 4), **rodent_back(0, 12), **rodent_tail(0, 3),
    },
    "walk_other": {
        **rodent_fore("R", -34, 12), **rodent_fore("L", 26, -16, 30, 30), **hind("R", 14, 6, 12, 20),
        **hind("L", -20, -14, 4), **rodent_back(0, -12), **rodent_tail(0, -3),
    },
    "gallop_extended": {
        **rodent_fore("L", -60, 30, -10), **rodent_fore("R", -52, 26, -10), **hind("L", 30, 40, 50, 30),
        **hind("R", 24, 34, 44, 30), **rodent_back(24), **rodent_neck(-16), **rodent_tail(-1),
    },
    "gallop_gathered": {
        **rodent_fore("L", 24, -30, 20, 30), **rodent_fore("R", 30, -36, 20, 30),
        **hind("L", -34, -10, 6, 0, 16), **hind("R", -26, -14, 6, 0, 16), **rodent_back(-44),
        **rodent_neck(20, nose=10), **rodent_tail(7),
    },
    "rear_up": {
        **rodent_fore("L", -10, -40, 20, 40), **rodent_fore("R", -2, -50, 20, 40), **hind("L", 34, -6, 4),
        **hind("R", 34, -6, 4), **rodent_back(-6), **rodent_neck(20), **rodent_tail(9),
    },
    "groom": {
        **rodent_fore("L", -40, -60, 10, 40), **rodent_fore("R", -40, -60, 10, 40), **hind("L", 26, -34, 0),
        **hind("R", 26, -34, 0), **rodent_back(-50), **rodent_neck(60), **rodent_tail(10, 6),
    },
    "sniff": {
        **rodent_fore("L", -10, 10), **rodent_fore("R", 4, -4), **rodent_neck(60), **rodent_tail(2, -4),
        **hind("L", 6, 4, 4), **hind("R", -6, -4, 0),
    },
    "look_up": {
        **rodent_fore("L", -14, 20), **rodent_fore("R", -6, 16), **rodent_neck(-60, nose=24),
        **rodent_back(24), **rodent_tail(0, 4),
    },
    "turn": {
        **rodent_fore("L", -6), **rodent_fore("R", 12, -8), **rodent_back(0, -56, 10), **rodent_neck(0, 56),
        **rodent_tail(0, -8), **hind("L", -10), **hind("R", 14, 6, 10),
    },
    "crouch": {
        **rodent_fore("L", 30, -50, 30), **rodent_fore("R", 30, -50, 30), **hind("L", -24, -30, -4, 0, 20),
        **hind("R", -24, -30, -4, 0, 20), **rodent_back(-20), **rodent_neck(-20), **rodent_tail(0, 10),
    },
}  # fmt: skip
RODENT_PITCH = {"rear_up": 62.0, "groom": 50.0, "look_up": 12.0}

POSES: dict[str, dict[str, JointAngles]] = {"dog": DOG, "rodent": RODENT}
PITCH: dict[str, dict[str, float]] = {"dog": DOG_PITCH, "rodent": RODENT_PITCH}
