"""The `Diffusion` type: the spectrum of an operator on a point cloud, and its heat kernel."""

import os
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from datasets_gen.records import load_record, save_record


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

    def __len__(self) -> int:
        """Return the number of points."""
        return len(self.points)

    def kernel(self, t: float, rows: NDArray[np.integer], cols: NDArray[np.integer]) -> NDArray[np.float64]:
        """m_t between two sets of points (Eq. 13).

        Returns
        -------
        (rows, cols) float64
        """
        weighted = self.eigenfunctions[rows] * np.exp(-self.eigenvalues * t)
        return weighted @ self.eigenfunctions[cols].T

    def signature(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """m_t(x, x) for every point and time, (n, T)."""
        return self.eigenfunctions**2 @ np.exp(-np.outer(self.eigenvalues, times))

    def heat_trace(self, times: NDArray[np.float64]) -> NDArray[np.float64]:
        """Sum of exp(-lambda_i t), (T,)."""
        return np.exp(-np.outer(self.eigenvalues, times)).sum(axis=0)

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write as ``.npz``."""
        save_record(
            path,
            "Diffusion",
            {name: getattr(self, name) for name in _ARRAYS},
            {"operator": self.operator, "parameters": self.parameters},
        )

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Diffusion":
        """Read a file written by `save`."""
        arrays, meta = load_record(path, "Diffusion")
        return cls(**arrays, **meta)


_ARRAYS = ("points", "normals", "areas", "eigenvalues", "eigenfunctions", "centers", "radii")
