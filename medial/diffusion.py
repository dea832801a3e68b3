"""The `Diffusion` type: the spectrum of an operator on a point cloud, and its heat kernel."""

import os
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import load_record, save_record
from medial.operator import Basis, Operator, build

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
    surface : Diffusion, optional
        A surface basis of the same points (operator ``"robust"``), for sharp refinement of a map.
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
    surface: "Diffusion | None" = None

    @classmethod
    def from_points(
        cls,
        points: NDArray[np.floating],
        normals: NDArray[np.floating] | None,
        operator: str = "medial",
        modes: int = 300,
        eta: float | None = 0.5,
        *,
        surface: bool = False,
        surface_modes: int = 200,
        start: "Diffusion | None" = None,
        **settings: Any,
    ) -> "Diffusion":
        """Build an operator on a cloud and take its smallest modes.

        Parameters
        ----------
        points : (n, 3)
            The cloud.
        normals : (n, 3) or None
            Outward normals; None estimates them.
        operator
            ``"medial"`` (Eqs. 4-15), ``"heat"`` (Gaussian weights alone [BSW09]) or ``"robust"`` (tufted
            Laplacian [Sharp & Crane 2020]).
        modes
            Eigenpairs to keep.
        eta
            Share of the Gaussian weights in Eq. 15; None takes phi alone, as in Eq. 8.
        surface
            Also build the companion surface basis.
        surface_modes
            Eigenpairs of the companion; at most a quarter of the points.
        start
            A similar operator on the same points (another eta, say): its modes start the search for these.
        **settings
            Further fields of `medial.operator.Operator`: sigma_e, sigma_t, cutoff, ...

        Raises
        ------
        InputError
            If the cloud or a setting cannot be used.
        """
        config = Operator(operator=operator, modes=modes, eta=eta, **settings)
        companion = None
        if surface:
            few = min(surface_modes, len(points) // 4)
            companion = cls._of(build(points, normals, Operator(operator="robust", modes=few)))
        warm = None if start is None else start.eigenfunctions
        return cls._of(build(points, normals, config, warm), companion)

    @classmethod
    def _of(cls, basis: Basis, surface: "Diffusion | None" = None) -> "Diffusion":
        return cls(**vars(basis), surface=surface)

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.points)

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
        if self.surface is not None:
            arrays |= {_SURFACE + name: getattr(self.surface, name) for name in _ARRAYS}
            meta["surface"] = {"operator": self.surface.operator, "parameters": self.surface.parameters}
        save_record(path, "Diffusion", arrays, meta)

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Diffusion":
        """Read a file written by `save`."""
        arrays, meta = load_record(path, "Diffusion")
        own = {name: arrays[name] for name in _ARRAYS}
        companion = meta.pop("surface", None)
        if companion is None:
            return cls(**own, **meta)
        other = cls(**{name: arrays[_SURFACE + name] for name in _ARRAYS}, **companion)
        return cls(**own, **meta, surface=other)


_ARRAYS = ("points", "normals", "areas", "eigenvalues", "eigenfunctions", "centers", "radii")
_SURFACE = "surface_"
