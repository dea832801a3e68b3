"""The tables of `docs/operator.md` on the built-in human.

python -m tests.benchmarks.operator_tables density [POINTS ...]
python -m tests.benchmarks.operator_tables areas [POINTS ...]
"""

import sys

import numpy as np

from medial import Diffusion, density_weights, dual_areas, medial_axis, similarity, surface_areas
from medial.areas.dual_area import JOINED, calibrated
from tests.benchmarks.operator_stages import scanned
from tests.medial.similarity.test_density import compare


def say(line):
    sys.stdout.write(line + "\n")
    sys.stdout.flush()


def density(sizes):
    """Eigenvalues 2 to 50 and m_t against those of the largest cloud, with the rule and as written."""
    for name, settings in (("density rule", {}), ("as written", {"reference_points": None})):
        made = {n: Diffusion.from_points(*scanned(n), modes=51, **settings) for n in sizes}
        probes = made[min(sizes)].points[::25]
        for n in sizes[:-1]:
            scale, spread, errors, medians = compare(made[n], made[sizes[-1]], probes)
            say(
                f"{name:<13} {n:>6} against {sizes[-1]}: scale {scale:.3f}, spread {100 * spread:.1f} %, "
                f"m_t {100 * errors.min():.1f} to {100 * errors.max():.1f} %, m_t(x, x) in the median "
                f"{100 * medians.min():.1f} to {100 * medians.max():.1f} %, area {made[n].areas.sum():.3f}"
            )
        say(f"{name:<13} {sizes[-1]:>6}: area {made[sizes[-1]].areas.sum():.3f}")


def areas(sizes):
    """Total dual area over total surface area, and the points with more than three times their cell."""
    for n in sizes:
        points, normals = scanned(n)
        surface = surface_areas(points, normals)
        phi = similarity(points, normals, weights=density_weights(surface))
        centers, radii = medial_axis(points, normals, phi)
        plain = dual_areas(points, centers, radii, normals)
        joined = dual_areas(points, centers, radii, normals, JOINED)
        for name, each in (
            ("Eq. 10", plain),
            ("nearest joined", joined),
            ("calibrated", calibrated(joined, surface)),
        ):
            large = each > 3 * surface
            say(f"{n:>6} {name:<15} total {each.sum() / surface.sum():.3f}, median ratio "
                f"{np.median(each / surface):.3f}, {100 * large.mean():.1f} % of the points hold "
                f"{100 * each[large].sum() / each.sum():.0f} % of it above three cells")  # fmt: skip


def main(arguments):
    sizes = [int(each) for each in arguments[1:]] or [5000, 10_000, 20_000, 40_000]
    {"density": density, "areas": areas}[arguments[0]](sizes)


if __name__ == "__main__":
    main(sys.argv[1:])
