"""Shapes whose surface and poses are formulas: the chain of capsules, dumbbell, thin sheet and torus.

Their medial axes, areas and isometries are known, so operators can be checked on them (Fig. 4 of the paper
has a chain of thick and thin pieces). All but the chain have more symmetries than a left and a right side:
which of the equivalent maps is the true one cannot be seen.

Metres; every pose stands on y = 0. Poses are maps of space near the rest pose; vertex i stays vertex i.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import partial
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation, Slerp

from datasets_gen.bodies.body_plan import BodyPlan, mesh_surface
from datasets_gen.bodies.implicit_surface import Body, Part, ellipsoid, sweep
from datasets_gen.bodies.skeleton import Skeleton, hinge

Array = NDArray[np.float64]
Ints = NDArray[np.int64]
Map = Callable[[Array], Array]

X, Y, Z = np.eye(3)
OWN_VARIATION = 0.07
"""Largest relative change of lengths and girths of the shapes of other seeds."""
STATIONS = 801
"""Samples of a bent axis; between them its frames turn evenly."""


@dataclass(frozen=True)
class AnalyticPlan:
    """A mesh at rest and maps of space that pose it.

    Attributes
    ----------
    name : str
    mesh : callable
        Vertices (v, 3) and faces (f, 3) of the default shape at rest.
    poses : mapping of str to map
        The first is the rest pose.
    seed : int
        0 is the default shape; others vary its proportions and keep its mesh.
    held_out : mapping of str to map
        As in `BodyPlan`.
    """

    name: str
    mesh: Callable[[], tuple[Array, Ints]]
    poses: Mapping[str, Map]
    seed: int = 0
    held_out: Mapping[str, Map] = field(default_factory=dict)

    def rest(self) -> tuple[Array, Ints]:
        """Vertices (v, 3) and faces (f, 3) at rest."""
        vertices, faces = self.mesh()
        return (varied(vertices, self.seed, OWN_VARIATION) if self.seed else vertices), faces

    def posed(self, vertices: Array) -> dict[str, Array]:
        """Vertices (v, 3) at rest in each pose, held-out ones among them; every pose stands on y = 0."""
        placed = {pose: by(vertices) for pose, by in {**self.poses, **self.held_out}.items()}
        return {pose: each - [0.0, each[:, 1].min(), 0.0] for pose, each in placed.items()}


def bent(points: Array, turns: Callable[[Array], Array], low: float, high: float) -> Array:
    """Bend space along the y axis between two heights; beyond them it moves rigidly.

    Slices y = const stay flat and rigid; the axis keeps its length. No two slices meet within the distance
    1 / |curvature| of the axis.

    Parameters
    ----------
    points : (n, 3)
    turns
        Rotation vector per metre (s, 3) at heights (s,), in the frame that moves along the axis: x and z bend
        it, y twists it.
    low, high
        Heights between which the axis bends.
    """
    at = np.linspace(low, high, STATIONS)
    from scipy.integrate import cumulative_trapezoid  # imports scipy.optimize: a sixth of a second

    middle = (at[1:] + at[:-1]) / 2
    steps = Rotation.from_rotvec(turns(middle) * (at[1] - at[0]))
    frames = [Rotation.identity()]
    for step in steps:
        frames.append(frames[-1] * step)
    frame = Rotation.concatenate(frames)
    axis = cumulative_trapezoid(frame.apply(Y), at, axis=0, initial=0) + low * Y
    inside = np.clip(points[:, 1], low, high)
    place = np.stack([np.interp(inside, at, axis[:, k]) for k in range(3)], axis=1)
    offset = points - inside[:, None] * Y
    return np.asarray(place + Slerp(at, frame)(inside).apply(offset))


def bend(
    low: float, high: float, degrees: float, *, about: Array = Z, waves: float = 0, twist: float = 0
) -> Map:
    """A map that bends by an angle in all, evenly or in waves, and twists by another.

    Parameters
    ----------
    low, high
        Heights between which the axis bends.
    degrees
        Of the whole bend; of each half wave if there are `waves`.
    about
        Axis of the bend, orthogonal to y.
    waves
        Number of full waves; 0 bends evenly.
    twist
        Degrees in all, which turn the plane of the bend along the axis.
    """
    length, total, spin = high - low, np.radians(degrees), np.radians(twist)

    def turns(heights: Array) -> Array:
        share = (heights - low) / length
        size = np.full(len(share), total / length)
        if waves:
            size = total * np.pi * waves / length * np.sin(2 * np.pi * waves * share)
        return size[:, None] * about + np.full((len(share), 1), spin / length) * Y

    return partial(bent, turns=turns, low=low, high=high)


def stretched(points: Array, factor: float) -> Array:
    """Longer along y and thinner, with the same volume."""
    thin = factor**-0.5
    return points * [thin, factor, thin]


def same(points: Array) -> Array:
    """Rest pose."""
    return points


def varied(points: Array, seed: int, amount: float) -> Array:
    """A subject of other proportions: longer or shorter along y, thicker here and thinner there.

    Parameters
    ----------
    points : (n, 3)
        At rest.
    seed
    amount
        Largest relative change of lengths and of girths.
    """
    rng = np.random.default_rng(seed)
    length = 1 + rng.uniform(-amount, amount)
    height = points[:, 1]
    share = (height - height.min()) / np.ptp(height)
    factors = []
    for _ in range(2):
        waves, phase, level = rng.uniform(0.4, 1.2), rng.uniform(0, 2 * np.pi), rng.uniform(-0.5, 0.5)
        factors.append(1 + amount * (level + 0.5 * np.sin(2 * np.pi * waves * share + phase)))
    return np.stack([points[:, 0] * factors[0], height * length, points[:, 2] * factors[1]], axis=1)


def _meshed(name: str, parts: tuple[Part, ...], edge: float, spacing: float) -> tuple[Array, Ints]:
    """Even triangles on a surface of parts."""
    alone = Skeleton((hinge("axis", None, (0, 0, 0), (0, 1, 0), X),))
    plan = BodyPlan(name, alone, Body(parts), (), edge, spacing, 1.0, {}, False)
    vertices, faces, _ = mesh_surface(plan)
    return vertices, faces


CHAIN = (  # share of the axis, radius
    (0.00, 0.085), (0.10, 0.135), (0.20, 0.120), (0.32, 0.060), (0.46, 0.175), (0.56, 0.185), (0.69, 0.050),
    (0.80, 0.105), (0.90, 0.115), (1.00, 0.070),
)  # fmt: skip
CHAIN_LENGTH, CHAIN_CAPS = 1.70, (0.085, 0.070)
BALLS, BAR = (0.30, 0.26), (0.30, 1.20)
SHEET, THICKNESS = (0.70, 1.00), 0.030
RING, TUBE = 0.55, 0.19


def capsule_chain(seed: int = 0) -> AnalyticPlan:
    """A body of revolution, thick and thin in turn (Fig. 4 of the paper): x^2 + z^2 = r(y)^2, round ends."""
    rows = [(at, radius, radius) for at, radius in CHAIN]
    part = sweep("axis", (0, 0, 0), (0, CHAIN_LENGTH, 0), rows, caps=CHAIN_CAPS, blend=0.01)
    top = CHAIN_LENGTH
    poses: dict[str, Map] = {
        "straight": same, "arc": bend(0, top, 110), "s_bend": bend(0, top, 80, about=X, waves=1),
        "helix": bend(0, top, 240, about=X, twist=200), "hook": bend(0.55 * top, top, 150),
        "stretched": partial(stretched, factor=1.25),
    }  # fmt: skip
    return AnalyticPlan(
        "capsule_chain", partial(_meshed, "capsule_chain", (part,), 0.0112, 0.006), poses, seed
    )


def dumbbell(seed: int = 0) -> AnalyticPlan:
    """Two unequal balls and a bar between them, smoothly joined."""
    low, high = BAR
    parts = (
        ellipsoid("axis", (0, 0, 0), (BALLS[0],) * 3, blend=0.02),
        ellipsoid("axis", (0, high + 0.25, 0), (BALLS[1],) * 3, blend=0.02),
        sweep("axis", (0, 0.1, 0), (0, high + 0.15, 0), [(0, 0.08, 0.08), (1, 0.08, 0.08)], caps=(0.08, 0.08),
            blend=0.08),
    )  # fmt: skip
    poses: dict[str, Map] = {
        "straight": same, "arc": bend(low, high, 70), "right_angle": bend(0.55, 0.95, 90, about=X),
        "s_bend": bend(low, high, 60, waves=1), "u_bend": bend(low, high, 150, about=X),
        "stretched": partial(stretched, factor=1.2),
    }  # fmt: skip
    return AnalyticPlan("dumbbell", partial(_meshed, "dumbbell", parts, 0.0155, 0.010), poses, seed)


def thin_sheet(seed: int = 0) -> AnalyticPlan:
    """A rectangular sheet with a round rim; its rolls keep all lengths of the middle surface."""
    half, diagonal = SHEET[1] / 2, Rotation.from_rotvec(np.radians(40) * Z)

    def rolled_askew(points: Array) -> Array:
        return np.asarray(diagonal.inv().apply(bend(-0.6, 0.6, 170, about=X)(diagonal.apply(points))))

    poses: dict[str, Map] = {
        "flat": same, "roll": bend(-half, half, 220, about=X),
        "wave": bend(-half, half, 75, about=X, waves=1.5), "fold": bend(-0.12, 0.12, 115, about=X),
        "roll_askew": rolled_askew, "twist": bend(-half, half, 0, twist=80),
    }  # fmt: skip
    return AnalyticPlan("thin_sheet", sheet_mesh, poses, seed)


def torus(seed: int = 0) -> AnalyticPlan:
    """A ring, which has a hole: no map from a sphere covers it."""

    def squeezed(points: Array) -> Array:
        return points * [1.28, 0.78, 1.0]

    def saddle(points: Array) -> Array:
        turn = np.arctan2(points[:, 1], points[:, 0])
        return points + 0.16 * np.cos(2 * turn)[:, None] * Z

    poses: dict[str, Map] = {
        "round": same, "squeezed": squeezed, "saddle": saddle, "folded": bend(-0.45, 0.45, 100, about=X),
        "twisted": bend(-0.6, 0.6, 0, twist=60), "stretched": partial(stretched, factor=1.3),
    }  # fmt: skip
    return AnalyticPlan("torus", torus_mesh, poses, seed)


def torus_mesh(around: int = 160, along: int = 56) -> tuple[Array, Ints]:
    """Vertices (v, 3) and faces (f, 3) of the torus about the z axis, rows shifted by half a step."""
    i, j = np.meshgrid(np.arange(around), np.arange(along), indexing="ij")
    u, v = 2 * np.pi * (i + 0.5 * (j % 2)) / around, 2 * np.pi * j / along
    ring = RING + TUBE * np.cos(v)
    vertices = np.stack([ring * np.cos(u), ring * np.sin(u), TUBE * np.sin(v)], axis=-1).reshape(-1, 3)
    a, b = i * along + j, (i + 1) % around * along + j
    c, d = i * along + (j + 1) % along, (i + 1) % around * along + (j + 1) % along
    even = (j % 2 == 0).ravel()[:, None]
    one = np.where(even, _rows(a, b, c), _rows(a, b, d))
    two = np.where(even, _rows(b, d, c), _rows(a, d, c))
    return vertices, np.concatenate([one, two])


def sheet_mesh(columns: int = 60, rows: int = 86, rim: int = 5) -> tuple[Array, Ints]:
    """Vertices (v, 3) and faces (f, 3) of the sheet in the plane z = 0: two grids and a half-round rim."""
    width, height = SHEET
    x, y = np.linspace(-width / 2, width / 2, columns), np.linspace(-height / 2, height / 2, rows)
    grid = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1).reshape(-1, 2)
    number = np.arange(columns * rows).reshape(columns, rows)
    loop = np.concatenate([number[:-1, 0], number[-1, :-1], number[:0:-1, -1], number[0, :0:-1]])
    outward = np.sign(grid[loop]) * (np.abs(grid[loop]) > np.array(SHEET) / 2 - 1e-9)
    outward /= np.linalg.norm(outward, axis=1, keepdims=True)
    half, count = THICKNESS / 2, columns * rows
    tilt = np.radians(90) - np.pi * np.arange(1, rim + 1) / (rim + 1)
    strips = [
        np.column_stack([grid[loop] + half * np.cos(t) * outward, np.full(len(loop), half * np.sin(t))])
        for t in tilt
    ]
    front, back = (np.column_stack([grid, np.full(count, z)]) for z in (half, -half))
    vertices = np.concatenate([front, back, *strips])
    a, b, c, d = number[:-1, :-1], number[1:, :-1], number[:-1, 1:], number[1:, 1:]
    top = np.concatenate([_rows(a, b, d), _rows(a, d, c)])
    rings = [loop, *(2 * count + k * len(loop) + np.arange(len(loop)) for k in range(rim)), loop + count]
    faces = [top, top[:, ::-1] + count]
    for upper, lower in pairwise(rings):
        up, low = np.roll(upper, -1), np.roll(lower, -1)
        faces += [_rows(upper, lower, low), _rows(upper, low, up)]
    return vertices, np.concatenate(faces)


def _rows(*corners: Ints) -> Ints:
    return np.stack([each.ravel() for each in corners], axis=1)
