"""Scans or maps of a set of pairs, in one process: what `tests.benchmarks.reproducibility` runs in many ways.

``python -m tests.benchmarks.reproducible_maps scan FOLDER POINTS PAIR ...`` writes the two scans of each
pair; ``... map FOLDER CHANGE OUT PAIR ...`` matches them after a change and writes what came out; ``prepare``
instead of ``map`` does the same without the map. A pair is written ``body,regime,seed``. The last line
printed is JSON: versions, and the kernels of the BLAS that was loaded.
"""

import json
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation

Float = NDArray[np.float64]

MODES = 200
POSES = {"human": ("tpose", "walk"), "quadruped": ("stand", "trot")}
"""Source and target of every pair; names of poses of the built-in bodies."""


class Regime(NamedTuple):
    """How both sides of a pair are scanned."""

    views: int
    threshold: float
    hard: bool


REGIMES = {"easy": Regime(6, 0.5, False), "hard-3": Regime(3, 0.8, True), "hard-6": Regime(6, 0.92, True)}
RESOLUTION = (200, 200)


class Pair(NamedTuple):
    """A body, how it is scanned, and the seed of scans and of the matcher."""

    body: str
    regime: str
    seed: int

    def __str__(self) -> str:
        """As an argument on the command line, and in file names."""
        return ",".join(map(str, self))

    @classmethod
    def of(cls, text: str) -> "Pair":
        """Read what `__str__` writes."""
        body, regime, seed = text.split(",")
        return cls(body, regime, int(seed))

    def scans(self, folder: Path) -> tuple[Path, Path]:
        """Files of the source and the target."""
        return folder / f"{self},source.npz", folder / f"{self},target.npz"


class Cloud(NamedTuple):
    """Points and normals, and the place of each point among those of the scan."""

    points: Float
    normals: Float
    order: NDArray[np.int64]


def turned(points: Float, normals: Float, rng: np.random.Generator) -> Cloud:
    """Each cloud by a rotation of its own."""
    turn = Rotation.random(random_state=int(rng.integers(2**31))).as_matrix().T
    return Cloud(points @ turn, normals @ turn, np.arange(len(points)))


def shuffled(points: Float, normals: Float, rng: np.random.Generator) -> Cloud:
    """Each cloud in an order of its own."""
    order = rng.permutation(len(points))
    return Cloud(points[order], normals[order], order)


def scaled(factor: float) -> Callable[..., Cloud]:
    """Both clouds in another unit."""
    return lambda points, normals, rng: Cloud(factor * points, normals, np.arange(len(points)))


def shifted(points: Float, normals: Float, rng: np.random.Generator) -> Cloud:
    """Each cloud by 100 body lengths in a direction of its own."""
    way = rng.standard_normal(3)
    away = 100 * np.ptp(points, axis=0).max() * way / np.linalg.norm(way)
    return Cloud(points + away, normals, np.arange(len(points)))


def noisy(points: Float, normals: Float, rng: np.random.Generator) -> Cloud:
    """Points moved by 1e-12 of the body's length."""
    noise = 1e-12 * np.ptp(points, axis=0).max() * rng.standard_normal(points.shape)
    return Cloud(points + noise, normals, np.arange(len(points)))


CHANGES: dict[str, Callable[..., Cloud]] = {
    "none": scaled(1.0),
    "rotation": turned,
    "permutation": shuffled,
    "times 1000": scaled(1000.0),
    "times 0.001": scaled(0.001),
    "translation": shifted,
    "noise 1e-12": noisy,
}


def write_scans(folder: Path, pairs: list[Pair], points: int) -> None:
    """Scan both poses of each pair."""
    import medialbench as mb

    for pair in pairs:
        body, regime = mb.load(pair.body), REGIMES[pair.regime]
        for path, pose in zip(pair.scans(folder), POSES[pair.body], strict=True):
            mb.scan(
                body[pose],
                threshold=regime.threshold,
                views=regime.views,
                points=points,
                seed=pair.seed,
                resolution=RESOLUTION,
            ).save(path)


def write_maps(folder: Path, change: str, out: Path, pairs: list[Pair], match: bool) -> None:
    """Write eigenvalues, samples and, if asked, the map of each pair, in the order of the scans' points."""
    from datasets_gen.records import atomic_path
    from medial import Diffusion
    from medial.matching.match import match_pair
    from medial.matching.nearest import single_blas_thread
    from medial.matching.prepared import prepare_pair
    from scanner_sim import Scan

    for pair in pairs:
        orders, diffusions = [], []
        for side, path in enumerate(pair.scans(folder)):
            scan = Scan.load(path)
            cloud = CHANGES[change](scan.points, scan.normals, np.random.default_rng([pair.seed, side]))
            orders.append(cloud.order)
            diffusions.append(Diffusion.from_points(cloud.points, cloud.normals, modes=MODES))
        with single_blas_thread():
            prepared = prepare_pair(*diffusions, None, pair.seed)
            found = match_pair(prepared) if match else None
        both = zip(orders, (prepared.source, prepared.target), strict=True)
        written = {"eigenvalues": np.stack([each.eigenvalues for each in diffusions])}
        written["samples"] = np.stack([np.sort(order[each.descriptors.samples]) for order, each in both])
        if found:
            back = np.argsort(orders[0])
            written["map"] = orders[1][found.source_to_target][back]
            written["confidence"] = found.confidence[back]
        with atomic_path(out / f"{pair}.npz") as path:
            np.savez(path, **written)


def about() -> dict[str, str]:
    """Versions, and the kernels of the BLAS libraries of NumPy and SciPy."""
    import numba
    import scipy
    from threadpoolctl import threadpool_info

    blas = sorted({str(info.get("architecture")) for info in threadpool_info() if info["user_api"] == "blas"})
    return {
        "python": sys.version.split()[0],
        "numpy": np.__version__,
        "scipy": scipy.__version__,
        "numba": numba.__version__,
        "blas": " and ".join(blas),
    }


def main() -> None:
    """Run one of the two commands."""
    command, folder, *rest = sys.argv[1:]
    if command == "scan":
        points, *names = rest
        write_scans(Path(folder), [Pair.of(name) for name in names], int(points))
    else:
        change, out, *names = rest
        write_maps(Path(folder), change, Path(out), [Pair.of(name) for name in names], command == "map")
    print(json.dumps(about()))  # noqa: T201


if __name__ == "__main__":
    main()
