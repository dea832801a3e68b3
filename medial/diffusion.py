"""The `Diffusion` type: the spectrum of an operator on a point cloud, and its heat kernel."""

import logging
import os
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.record_arrays import check_layout, check_values
from datasets_gen.records import load_record, save_record, unpacking
from medial.departures import Departures
from medial.device.backend import CPU, backend
from medial.operator import Operator, build_operator
from medial.places import distinct_places
from medial.spectrum.modes import smallest_modes

log = logging.getLogger(__name__)

GONE = 1e-25
"""Modes that have decayed to less than this count as gone: no sum feels them beside the first, which stays 1.
The subnormal numbers further down make matrix products several times slower, in single precision twenty."""


def decay(eigenvalues: NDArray[np.float64], times: NDArray[np.float64] | float) -> NDArray[np.float64]:
    """exp(-lambda_i t): what is left of every mode at some times, (k, T), or at one, (k,); 0 below `GONE`."""
    left = np.exp(-np.multiply.outer(eigenvalues, times))
    return np.where(left < GONE, 0.0, left)


@dataclass(frozen=True)
class Diffusion:
    r"""Eigenpairs of a Laplacian on n points: everything matching needs.

    Attributes
    ----------
    points, normals : (n, 3) float64
        The cloud, in its own units; normals are unit and outward.
    areas : (n,) float64
        Dual areas |\star p|, in squared units.
    eigenvalues : (k,) float64
        Ascending, the first 0 (one per connected component).
    eigenfunctions : (n, k) float64
        Orthonormal for the areas: ``psi.T @ diag(areas) @ psi == I``.
    centers : (n, 3) float64
        Estimated medial centres (Eq. 9); equal to `points` for surface operators.
    radii : (n,) float64
        Estimated medial radii (Eq. 9); 0 for surface operators.
    operator : str
        ``"medial"``, ``"heat"`` or ``"robust"``.
    parameters : dict
        The settings that made it, for the record.
    """

    points: NDArray[np.float64]
    normals: NDArray[np.float64]
    areas: NDArray[np.float64]
    eigenvalues: NDArray[np.float64]
    eigenfunctions: NDArray[np.float64]
    centers: NDArray[np.float64]
    radii: NDArray[np.float64]
    operator: str
    parameters: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def from_points(
        cls,
        points: NDArray[np.floating],
        normals: NDArray[np.floating] | None = None,
        operator: str = "medial",
        modes: int = 300,
        eta: float | None = 0.5,
        **settings: Any,
    ) -> "Diffusion":
        """Build an operator on a cloud and take its smallest modes.

        Points at the same place count as one while the operator is built; each of them gets its share of the
        area. Stray points, few and far from all others, are left out; they get no area, and the functions of
        the nearest point.

        Parameters
        ----------
        points : (n, 3)
            The cloud.
        normals : (n, 3), optional
            Outward normals; estimated where not given.
        operator
            ``"medial"`` (Eqs. 4-15), ``"heat"`` (Gaussian weights alone [BSW09]) or ``"robust"`` (tufted
            Laplacian [Sharp & Crane 2020]).
        modes
            Eigenpairs to keep; all but one of a cloud with fewer points.
        eta
            Share of the Gaussian weights in Eq. 15; None takes phi alone, as in Eq. 8.
        **settings
            Further fields of `medial.operator.Operator`: sigma_e, sigma_t, cutoff, ...;
            ``departures="none"`` is the paper as written, also for what uses the result.

        Raises
        ------
        InputError
            If the cloud cannot carry the operator, a setting cannot be used or the device is missing.
        """
        config = Operator(operator=operator, modes=modes, eta=eta, **settings)
        if config.device != CPU:
            backend(config.device)  # missing: say so before anything is computed
        places = distinct_places(points, normals)
        if modes >= len(places.cloud):
            most = len(places.cloud) - 1
            log.warning("%d places carry %d modes, not %d: so many are taken", most + 1, most, modes)
            modes = most
        stiffness, areas, centers, radii = build_operator(places.cloud, config)
        eigenvalues, eigenfunctions, residual = smallest_modes(
            stiffness,
            areas,
            modes,
            config.tolerance,
            factorise=operator == "robust",
            device=config.device,
        )
        return cls(
            places.points,
            places.normals,
            places.share_of(areas),
            eigenvalues,
            eigenfunctions[places.index],
            centers[places.index],
            radii[places.index],
            operator,
            asdict(config) | {"residual": residual},
        )

    def __repr__(self) -> str:
        """One line: operator, points n, modes k and area."""
        return (
            f"Diffusion({self.operator!r}, n={len(self)}, k={len(self.eigenvalues)}, "
            f"area={self.areas.sum():.6g})"
        )

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.points)

    @property
    def departures(self) -> Departures:
        """What its equations do differently from the paper; matching and Eq. 18 follow it."""
        return Departures.of(self.parameters.get("departures", "all"))

    def kernel(self, t: float, rows: NDArray[np.integer], cols: NDArray[np.integer]) -> NDArray[np.float64]:
        """m_t between two sets of points (Eq. 13).

        Returns
        -------
        (rows, cols) float64
        """
        weighted = self.eigenfunctions[rows] * decay(self.eigenvalues, t)
        return weighted @ self.eigenfunctions[cols].T

    def signature(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """m_t(x, x) for every point and time, (n, T)."""
        return self.eigenfunctions**2 @ decay(self.eigenvalues, times)

    def heat_trace(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Sum of exp(-lambda_i t), (T,)."""
        return np.asarray(decay(self.eigenvalues, times).sum(axis=0))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as ``.npz``."""
        arrays = {name: getattr(self, name) for name in _ARRAYS}
        meta: dict[str, Any] = {"operator": self.operator, "parameters": self.parameters}
        save_record(path, "Diffusion", arrays, meta)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Diffusion":
        """Read a file written by `save`; the companion surface basis of older files is left out."""
        arrays, meta = load_record(path, "Diffusion")
        meta.pop("surface", None)
        with unpacking(path, "Diffusion"):
            check_layout(arrays, _LAYOUT, finite="points normals areas eigenvalues eigenfunctions")
            check_values(cls, meta)
            return cls(**{name: arrays[name] for name in _ARRAYS}, **meta)


_LAYOUT = {
    **dict.fromkeys(("points", "normals", "centers"), "float n 3"),
    **dict.fromkeys(("areas", "radii"), "float n"),
    "eigenvalues": "float k",
    "eigenfunctions": "float n k",
}
"""Arrays of a file (`datasets_gen.record_arrays`)."""
_ARRAYS = ("points", "normals", "areas", "eigenvalues", "eigenfunctions", "centers", "radii")
