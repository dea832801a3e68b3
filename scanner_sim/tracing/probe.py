"""A small scan with a known answer, run in a child process to find out whether a variant is sound."""

import os

import numpy as np

from datasets_gen.shape import Shape
from scanner_sim.optics import viewpoints
from scanner_sim.scanner_config import ScannerConfig
from scanner_sim.tracing import variant
from scanner_sim.tracing.tracer import Tracer

TOLERANCE = 2e-3


def check_variant(name: str) -> None:
    """Exercise a variant as scans do; ends the process with an error if anything is off.

    Parameters
    ----------
    name
        Mitsuba variant.

    Raises
    ------
    RuntimeError
        If the variant computes something wrong.
    """
    os.environ.setdefault("DRJIT_NO_LOG", "1")
    with variant.active(name) as mi:
        _arithmetic(mi, name)
        _mesh_file(mi)
    _scan(name)


def _arithmetic(mi: object, name: str) -> None:
    """Operations that abort with some versions of LLVM."""
    import drjit as dr

    if name == variant.SCALAR:
        return
    x = mi.Float(np.linspace(-2, 2, 5, dtype=np.float32))  # type: ignore[attr-defined]
    if not np.allclose(np.array(dr.minimum(x, 1)), np.minimum(np.linspace(-2, 2, 5), 1)):
        raise RuntimeError("minimum is wrong")
    if not np.allclose(np.array(dr.clip(x, -1, 1)), np.clip(np.linspace(-2, 2, 5), -1, 1)):
        raise RuntimeError("clip is wrong")


def _mesh_file(mi: object) -> None:
    """Loading a mesh hides further operations."""
    mi.load_dict({"type": "scene", "ball": {"type": "sphere"}, "cube": {"type": "cube"}})  # type: ignore[attr-defined]


def _scan(name: str) -> None:
    """Scan a cube's face, whose cosines and hits are known."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)], float)
    quads = [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]]
    faces = np.array([[q[0], *pair] for q in quads for pair in (q[1:3], q[2:4])], np.int32)
    config = ScannerConfig(views=1, resolution=(64, 48), shading="flat")
    tracer = Tracer(Shape(corners, faces, "probe/cube", "probe", "cube"), config, name)
    pose = viewpoints.poses(np.array([[0.0, 0.0, 1.0]]), config.min_range + tracer.frame.diagonal / 2)[0]
    hits = tracer.view(pose)
    toward = np.array([config.baseline, 0, 0]) - hits.points
    cosine = -toward[:, 2] / np.linalg.norm(toward, axis=1)
    if len(hits.points) < 500 or set(hits.face_ids) != {10, 11}:
        raise RuntimeError(f"{len(hits.points)} camera rays hit faces {sorted(set(hits.face_ids))}")
    if np.abs(hits.radiance - np.abs(cosine)).max() > TOLERANCE:
        raise RuntimeError("reflected light differs from the cosine")
