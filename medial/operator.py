"""What is built, in which order: from a cloud to the matrix of an operator. `Operator` holds the settings."""

import logging
from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array

from datasets_gen.records import InputError
from datasets_gen.values import CheckedSettings, check_count
from medial.areas.dual_area import JOINED, areas_of_hulls, calibrated, medial_balls
from medial.areas.surface_cells import REFERENCE_POINTS, density_weights, surface_cells
from medial.departures import ALL_DEPARTURES, Departures
from medial.device.backend import CPU, check_device
from medial.laplacian.heat import heat_laplacian
from medial.laplacian.tufted import tufted_laplacian
from medial.laplacian.weights import TINY, combine, diffusion_rates, gaussian_weights, laplacian
from medial.similarity.candidate_ball import smallest_width
from medial.similarity.emptiness import Settings
from medial.similarity.similarity import check_similarity, similarity_of
from medial.validation import OrientedCloud

log = logging.getLogger(__name__)

Array = NDArray[np.float64]

OPERATORS = ("medial", "heat", "robust")
SIZE_RULES = ("density_weights", "nearest_join", "area_calibration", "diffusion_rates")
"""Departures that `reference_points=None` switches off: the result then depends on the number of points."""


@dataclass(frozen=True, kw_only=True)
class Operator(CheckedSettings):
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
        Cloud size that sigma_e, the Gaussian part and the areas refer to (`docs/operator.md`); None switches
        off the departures in `SIZE_RULES`, so that the result depends on the number of points.
    tolerance
        Residual of the modes relative to the largest eigenvalue.
    device : {"cpu", "cuda", "llvm"}
        Where similarities and modes are computed (`medial.device`).
    departures
        What is done differently from the paper (`medial.Departures`); also ``"all"``, ``"none"`` (Eqs. 5-15
        as written), or true and false by name.
    """

    kind: ClassVar[str] = "operator setting"
    operator: str = "medial"
    modes: int = 300
    eta: float | None = 0.5
    sigma_e: float = 5.0
    sigma_t: float = 0.7
    cutoff: float = 1e-6
    reference_points: float | None = REFERENCE_POINTS
    tolerance: float = 1e-6
    device: str = CPU
    departures: Departures = ALL_DEPARTURES

    def __post_init__(self) -> None:
        self.check_types()
        if self.operator not in OPERATORS:
            raise InputError(f"unknown operator {self.operator!r}; choose one of {', '.join(OPERATORS)}")
        check_count(self.modes, "modes")
        if self.eta is not None and not 0 <= self.eta <= 1:
            raise InputError(f"eta is {self.eta}; choose it in [0, 1]")
        if self.reference_points is not None and not 0 < self.reference_points < np.inf:
            raise InputError(
                f"reference_points is {self.reference_points}; give a positive number (in Python also None)"
            )
        if not 0 < self.tolerance < 1:
            raise InputError(f"tolerance is {self.tolerance}; choose it in (0, 1)")
        check_similarity(self.sigma_e, self.sigma_t, self.cutoff)
        check_device(self.device)
        departures = Departures.of(self.departures)
        if self.reference_points is None:
            departures = departures.as_written(*SIZE_RULES)
        object.__setattr__(self, "departures", departures)


def build_operator(cloud: OrientedCloud, config: Operator) -> tuple[csr_array, Array, Array, Array]:
    """Assemble ``S psi = lambda A psi`` of a cloud.

    Parameters
    ----------
    cloud
        Without coinciding points (`medial.places`).
    config
        Settings.

    Returns
    -------
    stiffness : (n, n) csr_array
        S, symmetric with zero row sums.
    areas : (n,)
        Diagonal of A, in squared units.
    centers : (n, 3)
    radii : (n,)
        Medial axis (Eq. 9); the points and 0 for surface operators.
    """
    flat = np.zeros(len(cloud))
    if config.operator == "robust":
        return (*tufted_laplacian(cloud.points), cloud.points, flat)
    surface = surface_cells(cloud)
    if config.operator == "heat":
        return heat_laplacian(cloud, surface, config.departures), surface, cloud.points, flat
    weights, areas, centers, radii = medial_weights(cloud, surface, config)
    return laplacian(weights, areas), areas, centers, radii


def medial_weights(
    cloud: OrientedCloud, surface: Array, config: Operator
) -> tuple[csr_array, Array, Array, Array]:
    """Weights of the medial Laplacian: similarity, medial axis, dual areas, Gaussian weights (Eqs. 4-15).

    Parameters
    ----------
    cloud
    surface : (n,)
        Surface areas (`medial.areas.surface_cells.surface_cells`).
    config
        Settings.

    Returns
    -------
    weights : (n, n) csr_array
        Phi (Eq. 7), or sigma of Eq. 15.
    areas : (n,)
        Dual areas (Eq. 10).
    centers : (n, 3)
    radii : (n,)
        Medial axis (Eq. 9).
    """
    own, reference = config.departures, config.reference_points or REFERENCE_POINTS
    mass = density_weights(surface, reference) if own.density_weights else np.ones(len(cloud))
    phi = similarity_of(cloud, similarity_settings(cloud, config), mass, config.device)
    if phi.nnz == 0:
        log.warning("no two points share a medial ball (a flat cloud?): only the Gaussian weights act")
    centers, radii = medial_balls(cloud, phi)
    nearest = min(JOINED, len(cloud) - 1) if own.nearest_join else 0
    areas = areas_of_hulls(cloud.points, cloud.tree, centers, radii, nearest)
    areas = np.where(np.isnan(areas), surface, areas)
    if own.area_calibration:
        areas = calibrated(areas, surface)
    if config.eta is None:
        return phi, areas, centers, radii
    alpha, bandwidths = gaussian_weights(cloud.points, surface, cloud.tree, own)
    rates = diffusion_rates(bandwidths, float(surface.sum()), reference) if own.diffusion_rates else 1.0
    return combine(phi, alpha, areas, config.eta, rates), areas, centers, radii


def similarity_settings(cloud: OrientedCloud, config: Operator) -> Settings:
    """Parameters of Eq. 7 for a cloud: its radius cap, and what is cut off."""
    cap = smallest_width(cloud.points)
    if not config.departures.radius_cap and cap > 0:
        cap = np.inf
    cutoff = config.cutoff if config.departures.truncation else TINY
    return Settings(float(config.sigma_e), float(config.sigma_t), -np.log(cutoff), cap, cutoff)
