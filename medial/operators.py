"""From a cloud to the modes of an operator: one function per operator, one configuration for all."""

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import InputError
from medial.area import dual_areas, medial_axis
from medial.checks import check_cloud
from medial.heat import heat_laplacian
from medial.laplacian import combine, gaussian_weights, laplacian
from medial.robust import tufted_laplacian
from medial.similarity import similarity
from medial.spectrum import smallest_modes, sparse_modes
from medial.surface import REFERENCE_POINTS, density_weights, surface_areas

OPERATORS = ("medial", "heat", "robust")


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
        Cloud size sigma_e refers to (`medial.density_weights`); None counts every point once, as Eq. 5 is
        written.
    tolerance
        Residual of the modes relative to the largest eigenvalue.
    """

    operator: str = "medial"
    modes: int = 300
    eta: float | None = 0.5
    sigma_e: float = 5.0
    sigma_t: float = 0.7
    cutoff: float = 1e-6
    reference_points: float | None = REFERENCE_POINTS
    tolerance: float = 1e-6

    def __post_init__(self) -> None:
        if self.operator not in OPERATORS:
            raise InputError(f"unknown operator {self.operator!r}; choose one of {', '.join(OPERATORS)}")
        if self.modes < 1:
            raise InputError(f"modes is {self.modes}; ask for at least 1")
        if self.eta is not None and not 0 <= self.eta <= 1:
            raise InputError(f"eta is {self.eta}; choose it in [0, 1]")


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


def build(points: NDArray[np.floating], normals: NDArray[np.floating] | None, config: Operator) -> Basis:
    """Build the operator of a cloud and take its modes.

    Raises
    ------
    InputError
        If the cloud cannot carry the operator.
    """
    if normals is None:
        raise InputError("normals are missing; give outward normals")
    points, normals = check_cloud(points, normals)
    if config.modes >= len(points):
        raise InputError(
            f"{config.modes} modes asked of {len(points)} points; ask for fewer or give more points"
        )
    centers, radii = points, np.zeros(len(points))
    if config.operator == "robust":
        stiffness, areas = tufted_laplacian(points)
        values, functions = sparse_modes(stiffness, areas, config.modes)
    elif config.operator == "heat":
        areas = surface_areas(points, normals)
        values, functions = smallest_modes(
            heat_laplacian(points, areas), areas, config.modes, config.tolerance
        )
    else:
        surface = surface_areas(points, normals)
        weights = None
        if config.reference_points is not None:
            weights = density_weights(surface, config.reference_points)
        phi = similarity(points, normals, config.sigma_e, config.sigma_t, config.cutoff, weights=weights)
        centers, radii = medial_axis(points, normals, phi)
        areas = dual_areas(points, centers, radii, normals)
        if config.eta is not None:
            phi = combine(phi, gaussian_weights(points), areas, config.eta)
        values, functions = smallest_modes(laplacian(phi, areas), areas, config.modes, config.tolerance)
    return Basis(points, normals, areas, values, functions, centers, radii, config.operator, asdict(config))
