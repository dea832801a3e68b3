"""From a cloud to the modes of an operator: one function per operator, one configuration for all."""

import logging
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from datasets_gen.records import InputError
from medial.areas.dual_area import calibrated, dual_areas, medial_axis
from medial.areas.surface_cells import REFERENCE_POINTS, density_weights, surface_areas
from medial.device.backend import CPU, backend, check_device
from medial.laplacian.heat import heat_laplacian
from medial.laplacian.tufted import tufted_laplacian
from medial.laplacian.weights import combine, diffusion_rates, gaussian_weights, laplacian
from medial.outward import check_normals, estimate_normals
from medial.similarity.leaves import kd_order
from medial.similarity.similarity import check_similarity, similarity
from medial.spectrum.modes import Modes, smallest_modes
from medial.validation import check_cloud, check_points

log = logging.getLogger(__name__)

OPERATORS = ("medial", "heat", "robust")
NEAREST = 12  # points next to each one that join its hull (`dual_areas`)


@dataclass(frozen=True, kw_only=True)
class Operator:
    """Settings of an operator.

    Attributes
    ----------
    operator : {"medial", "heat", "robust"}
    modes
        Eigenpairs to keep.
    eta
        Share of the Gaussian weights in Eq. 15; None takes phi alone (Eq. 8).
    sigma_e, sigma_t
        Tolerances of Eq. 7.
    cutoff
        Smallest similarity kept.
    reference_points
        Cloud size that sigma_e, the Gaussian part and the areas refer to (`docs/operator.md`); None takes
        every equation as written, so that the result depends on the number of points.
    tolerance
        Residual of the modes relative to the largest eigenvalue.
    device : {"cpu", "cuda", "llvm"}
        Where similarities and modes are computed (`medial.device`).
    """

    operator: str = "medial"
    modes: int = 300
    eta: float | None = 0.5
    sigma_e: float = 5.0
    sigma_t: float = 0.7
    cutoff: float = 1e-6
    reference_points: float | None = REFERENCE_POINTS
    tolerance: float = 1e-6
    device: str = CPU

    def __post_init__(self) -> None:
        if self.operator not in OPERATORS:
            raise InputError(f"unknown operator {self.operator!r}; choose one of {', '.join(OPERATORS)}")
        if self.modes < 1:
            raise InputError(f"modes is {self.modes}; ask for at least 1")
        if self.eta is not None and not 0 <= self.eta <= 1:
            raise InputError(f"eta is {self.eta}; choose it in [0, 1]")
        if self.reference_points is not None and not 0 < self.reference_points < np.inf:
            raise InputError(f"reference_points is {self.reference_points}; give a positive number or None")
        if not 0 < self.tolerance < 1:
            raise InputError(f"tolerance is {self.tolerance}; choose it in (0, 1)")
        check_similarity(self.sigma_e, self.sigma_t, self.cutoff)
        check_device(self.device)


@dataclass(frozen=True)
class Basis:
    """The fields of a `medial.Diffusion`, without a companion."""

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    areas: NDArray[np.float64]
    eigenvalues: NDArray[np.float64]
    eigenfunctions: NDArray[np.float64]
    centers: NDArray[np.float64]
    radii: NDArray[np.float64]
    operator: str
    parameters: dict[str, Any]


def build(
    points: NDArray[np.floating],
    normals: NDArray[np.floating] | None,
    config: Operator,
    start: NDArray[np.float64] | None = None,
) -> Basis:
    """Build the operator of a cloud and take its modes.

    Points at the same place count as one while the operator is built; each of them gets its share of the
    area.

    Parameters
    ----------
    points : (n, 3)
    normals : (n, 3) or None
        Outward normals; None estimates them.
    config
        Settings.
    start : (n, k), optional
        Eigenfunctions of a similar operator on the same points: a warm start for the modes.

    Raises
    ------
    InputError
        If the cloud cannot carry the operator, or the device is missing.
    """
    if config.device != CPU:
        backend(config.device)  # missing: say so before anything is computed
    given = check_points(points)
    places, which, copies = np.unique(given, axis=0, return_inverse=True, return_counts=True)
    which = which.ravel()
    if len(places) < len(given):
        log.info("%d of %d points coincide with another: merged", len(given) - len(places), len(given))
    check_points(places)
    if config.modes >= len(places):
        raise InputError(
            f"{config.modes} modes asked of {len(places)} points; ask for fewer or give more points"
        )
    if normals is None:
        log.warning("normals are missing: estimated from the points and oriented along a spanning tree")
        merged = estimate_normals(places)
    else:
        merged = check_normals(places, _merged_normals(check_cloud(given, normals)[1], which, len(places)))
    order = kd_order(places)
    place = np.empty_like(order)
    place[order] = np.arange(len(order))
    back = place[which]  # where each given point is in the sorted cloud
    warm = None if start is None else start[np.unique(which, return_index=True)[1]][order]
    parts = _build(places[order], merged[order], config, warm)
    return Basis(
        given,
        merged[which],
        parts.areas[back] / copies[which],
        parts.modes.eigenvalues,
        parts.modes.eigenfunctions[back],
        parts.centers[back],
        parts.radii[back],
        config.operator,
        asdict(config) | {"residual": parts.modes.residual},
    )


def _merged_normals(
    normals: NDArray[np.float64], which: NDArray[np.integer], count: int
) -> NDArray[np.float64]:
    """Mean direction of the normals at every place; the first of them where they cancel."""
    total = np.zeros((count, 3))
    np.add.at(total, which, normals)
    length = np.linalg.norm(total, axis=1, keepdims=True)
    first = np.empty(count, dtype=np.int64)
    first[which[::-1]] = np.arange(len(which))[::-1]
    return np.where(length > 1e-6, total / np.maximum(length, 1e-6), normals[first])


@dataclass(frozen=True)
class _Parts:
    areas: NDArray[np.float64]
    modes: Modes
    centers: NDArray[np.float64]
    radii: NDArray[np.float64]


def _build(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    config: Operator,
    start: NDArray[np.float64] | None,
) -> _Parts:
    centers, radii = points, np.zeros(len(points))
    if config.operator == "robust":
        stiffness, areas = tufted_laplacian(points)
        return _Parts(
            areas,
            smallest_modes(stiffness, areas, config.modes, config.tolerance, factorise=True),
            centers,
            radii,
        )
    areas = surface_areas(points, normals)
    if config.operator == "heat":
        stiffness = heat_laplacian(points, areas)
    else:
        weights, areas, centers, radii = medial_weights(points, normals, areas, config)
        stiffness = laplacian(weights, areas)
    modes = smallest_modes(stiffness, areas, config.modes, config.tolerance, start, device=config.device)
    return _Parts(areas, modes, centers, radii)


def medial_weights(
    points: NDArray[np.float64],
    normals: NDArray[np.float64],
    surface: NDArray[np.float64],
    config: Operator,
) -> tuple[csr_array, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Weights of the medial Laplacian (phi, or sigma of Eq. 15), dual areas, medial centres and radii.

    Parameters
    ----------
    points, normals : (n, 3)
    surface : (n,)
        Surface areas (`medial.surface_areas`).
    config
        Settings.
    """
    reference = config.reference_points
    mass = None if reference is None else density_weights(surface, reference)
    phi = similarity(
        points,
        normals,
        config.sigma_e,
        config.sigma_t,
        config.cutoff,
        weights=mass,
        device=config.device,
    )
    if phi.nnz == 0:
        log.warning("no two points share a medial ball (a flat cloud?): only the Gaussian weights act")
    centers, radii = medial_axis(points, normals, phi)
    if reference is None:
        areas = dual_areas(points, centers, radii, normals)
    else:
        areas = calibrated(
            dual_areas(points, centers, radii, normals, min(NEAREST, len(points) - 1)), surface
        )
    if config.eta is None:
        return phi, areas, centers, radii
    alpha, bandwidths = gaussian_weights(points, surface)
    rates = 1.0 if reference is None else diffusion_rates(bandwidths, float(surface.sum()), reference)
    return combine(phi, alpha, areas, config.eta, rates), areas, centers, radii
