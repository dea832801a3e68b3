"""Functional maps [OBCS*12] with the orientation term of [RPWO18], refined by ZoomOut [MRR*19].

They come from the package `pyfmaps`, which works on meshes. Clouds enter it through the modes of the
tufted Laplacian and through gradients by local least squares, which is all that its solver asks of a
mesh.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import csr_array, diags_array

from datasets_gen.values import check_count
from evaluation.experiment.toml_tables import expect
from evaluation.methods.base import Method, MethodInput, dense, require
from evaluation.methods.gradients import gradients, tangent_frames
from medial import Diffusion, Matching
from medial.matching.confidence import confidence_of_residual


@dataclass(frozen=True, kw_only=True)
class FunctionalMaps(Method):
    """Wave kernel signatures to a functional map, ZoomOut, nearest neighbours."""

    modes: int = 30
    """Size of the first functional map."""
    final: int = 150
    """Size after ZoomOut; less if the operator has fewer modes."""
    step: int = 10
    """Modes added per step of ZoomOut."""
    signatures: int = 100
    """Wave kernel signatures; every fifth enters the solver."""
    orientation: float = 1.0
    """Weight of the orientation term relative to the others; 0 cannot tell left from right."""

    def __post_init__(self) -> None:
        """Check ranges."""
        check_count(self.modes, "modes", 2)
        check_count(self.step, "step")
        check_count(self.signatures, "signatures")
        expect(self.final >= self.modes, f"final is {self.final!r}; give at least modes, {self.modes}")
        expect(self.orientation >= 0, f"orientation must not be negative, got {self.orientation!r}")

    requires = {"pyFM": "pyfmaps"}  # noqa: RUF012

    @property
    def operators(self) -> tuple[str, ...]:
        """The modes it works in."""
        return ("robust",)

    def match(self, source: MethodInput, target: MethodInput, seed: int) -> Matching:
        """The map of functions on the target to functions on the source, read as a map of points."""
        from pyFM.functional import FunctionalMapping
        from pyFM.signatures import auto_WKS

        here, there = _CloudMesh(source.operators["robust"]), _CloudMesh(target.operators["robust"])
        held = min(here.eigenvectors.shape[1], there.eigenvectors.shape[1])
        require(held, self.modes, "functional maps (modes)")
        model = FunctionalMapping(there, here)  # functions go from target to source, so points go back
        described = [auto_WKS(m.eigenvalues, m.eigenvectors, self.signatures)[:, ::5] for m in (there, here)]
        model.add_descriptors(*described)
        model.fit(K=(self.modes, self.modes), w_orient=self.orientation)
        steps = max(0, (min(self.final, held) - self.modes) // self.step)
        refined = model.zoomout_refine(nit=steps, step=self.step)
        image = model.get_p2p(refined, n_jobs=1)
        size = refined.shape[0]
        residual = np.linalg.norm(
            here.eigenvectors[:, :size] @ refined - there.eigenvectors[image, :size], axis=1
        )
        return dense(image, confidence_of_residual(residual), cost=float(residual.mean()), seed=seed)


class _CloudMesh:
    """What `pyFM` asks of a mesh, for a cloud of unit area."""

    def __init__(self, diffusion: Diffusion) -> None:
        area = diffusion.areas.sum()
        self.eigenvalues = diffusion.eigenvalues * area
        self.eigenvectors = diffusion.eigenfunctions * np.sqrt(area)
        self.A = self.mass = diags_array(diffusion.areas / area).tocsr()
        self.n_vertices, self.area = len(diffusion), 1.0
        size = np.sqrt(area)
        self._gradients = gradients(diffusion.points / size, diffusion.normals)
        self._frames, self._normals = tangent_frames(diffusion.normals), diffusion.normals

    def project(self, func: NDArray[np.float64], k: int | None = None) -> NDArray[np.float64]:
        """Coefficients of functions, (k, p)."""
        return self.eigenvectors[:, :k].T @ (self.mass @ func)

    def l2_sqnorm(self, func: NDArray[np.float64]) -> NDArray[np.float64]:
        """Squared norms of functions, (p,)."""
        return np.einsum("np,np->p", func, self.mass @ func)

    def gradient(self, f: NDArray[np.float64], normalize: bool = False) -> NDArray[np.float64]:
        """Gradient of a function in the tangent planes, (n, 2)."""
        found = np.column_stack([each @ f for each in self._gradients])
        return found / np.linalg.norm(found, axis=1, keepdims=True).clip(1e-300) if normalize else found

    def orientation_op(self, gradient: NDArray[np.float64], normalize: bool = False) -> csr_array:
        """The operator g -> (grad f x grad g) . n, (n, n)."""
        along_u, along_v = self._gradients
        return csr_array(diags_array(gradient[:, 0]) @ along_v - diags_array(gradient[:, 1]) @ along_u)
