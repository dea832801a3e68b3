"""A small results folder, written with the store's own functions; its errors are known."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import trimesh

from datasets_gen import Collection, Shape
from evaluation.experiment.tasks import Task
from evaluation.methods import dense
from evaluation.metrics.correspondence import CURVE, pck_curve
from evaluation.results.store import FORMAT, ResultsStore, write_json
from evaluation.results.table import COLUMNS
from medial import Diffusion
from scanner_sim import sample

POSES = ("rest", "bent")
THRESHOLDS = (0.3, 0.8)
METHODS = {"medial diffusion": ("medial", 3.0), "heat kernel": ("heat", 9.0)}
"""Label: operator and constant geodesic error."""


def collection(subject="blob"):
    mesh = trimesh.creation.capsule(height=2.0, radius=0.5, count=[16, 16])
    faces = np.array(mesh.faces, np.int32)
    poses = {
        "rest": mesh.vertices,
        "bent": mesh.vertices + 0.2 * np.c_[mesh.vertices[:, 2] ** 2, 0 * mesh.vertices[:, :2]],
    }
    shapes = tuple(
        Shape(np.array(v, float), faces, f"{subject}/{pose}", subject, pose) for pose, v in poses.items()
    )
    return Collection(subject, shapes, shapes[0])


def diffusion(scan, operator):
    n = len(scan)
    flat = np.full((n, 2), n**-0.5)
    return Diffusion(
        points=scan.points,
        normals=scan.normals,
        areas=np.ones(n),
        eigenvalues=np.array([0.0, 1.0]),
        eigenfunctions=flat,
        centers=scan.points * 0.5,
        radii=np.ones(n),
        operator=operator,
    )


def write_results(folder, *, subjects=("blob",), seeds=(0,), failures=()):
    """A results folder as `evaluation.run` leaves it; every map is the identity."""
    store = ResultsStore(folder)
    rows, datasets = [], {}
    for subject in subjects:
        shapes = collection(subject)
        datasets[subject] = f"{subject}-shape"
        keep(store, "shape", datasets[subject], shapes)
        for seed in seeds:
            rows += _rows(store, subject, shapes, seed)
    table = pd.DataFrame(rows, columns=list(COLUMNS)).astype(COLUMNS)
    folder.mkdir(exist_ok=True)
    table.to_parquet(folder / "table.parquet")
    lines = pd.DataFrame(failures, columns=["key", "stage", "label", "kind", "reason"])
    lines.to_csv(folder / "failures.csv", index=False)
    (folder / "experiment.toml").write_text('name = "small"\ndescription = "two <poses>"\nseeds = [0]\n')
    info = {
        "format": FORMAT,
        "datasets": datasets,
        "versions": {"numpy": np.__version__},
        "wall_seconds": 12.5,
    }
    write_json(folder / "run.json", info)
    return store


def keep(store, stage, key, value, inputs=()):
    """Store a result as a worker does: its file, then its record."""
    value.save(store.path(stage, key))
    store.write_record(Task(key, stage, {}, dict(inputs), key), 2.0, 1.9, None, {})


def _scan(shapes, pose):
    """The same surface points in every pose."""
    scan = sample(shapes.reference, 200, seed=1)
    points = shapes[pose].at(scan.face_ids, scan.barycentrics)
    return replace(scan, points=points, true_points=points)


def _rows(store, subject, shapes, seed):
    clouds = {}
    for pose in POSES:
        for threshold in THRESHOLDS:
            key = f"{subject}-{pose}-{threshold}-{seed}"
            keep(store, "scan", key, _scan(shapes, pose))
            clouds[pose, threshold] = key
    for threshold in THRESHOLDS:
        shared = {"dataset": subject, "subject": subject, "regime": f"threshold {threshold}", "views": "6"}
        shared |= {
            "n_points": 200,
            "seed": seed,
            "source_missing": threshold / 2,
            "source_threshold": threshold,
        }
        for operator, level in (("medial", 0.1), ("heat", 0.4)):
            errors = {"eq18": level * threshold, "eq18_trace": level, "eq18_relative": level}
            for pose in POSES:
                about = {"kind": "stability", "method": operator, "operator": operator, "score_key": "s"}
                about |= {"source_pose": pose, "target_pose": "rest", "source_scan": clouds[pose, threshold]}
                yield {**shared, **about, **errors}
        for label, (operator, error) in METHODS.items():
            source, target = clouds["rest", threshold], clouds["bent", threshold]
            key = f"{subject}-{threshold}-{seed}-{operator}"
            _write_map(store, key, source, operator, error)
            about = {
                "kind": "matching",
                "method": label,
                "operator": operator,
                "map_key": key,
                "score_key": key,
            }
            about |= {
                "source_pose": "rest",
                "target_pose": "bent",
                "source_scan": source,
                "target_scan": target,
            }
            about |= {"target_threshold": threshold, "target_missing": threshold / 2, "seconds_match": 2.0}
            errors = {"geodesic_mean": error + seed, "geodesic_median": error, "medial_mean": 1.0}
            errors |= {"geodesic_symmetric_mean": error, "flipped": operator == "heat", "coverage": 1.0}
            errors |= {"matched": 1.0}
            errors |= {"pck_auc": 1 - error / 25, "overlap_iou": 0.9}
            yield {**shared, **about, **errors}


def _write_map(store, key, scan_key, operator, error):
    scan = store.scan(scan_key)
    n = len(scan)
    found = dense(np.arange(n), np.ones(n), landmarks=np.array([[0, 0], [5, 5]]))
    inputs = {"source_scan": scan_key}
    if operator == "medial":
        keep(store, "operator", f"{key}-operator", diffusion(scan, operator))
        inputs["source_medial"] = f"{key}-operator"
    keep(store, "map", key, found, inputs)
    curve = pck_curve(np.full(n, error / 100), CURVE)
    store.write_record(
        Task(key, "score", {}, {}, key),
        0.1,
        0.1,
        None,
        json.loads(json.dumps({"row": {}, "curve": curve.tolist()})),
    )


@pytest.fixture(scope="session")
def results(tmp_path_factory):
    """Folder of a small finished run; do not change it."""
    folder = tmp_path_factory.mktemp("results")
    write_results(folder, subjects=("blob", "worm"), seeds=(0, 1))
    return folder


def save_plainly(figure, folder, name):
    """A small picture, and an empty PDF."""
    folder.mkdir(parents=True, exist_ok=True)
    figure.savefig(folder / f"{name}.png", dpi=30)
    (folder / f"{name}.pdf").write_bytes(b"%PDF-1.4")


@pytest.fixture
def plain_figures(monkeypatch):
    """Figures are drawn once, small, and PDFs are empty: for tests of what is around them."""
    monkeypatch.setattr("reports.page.pictures.save", save_plainly)


@pytest.fixture(scope="module")
def plain_figures_of_module():
    """The same for all tests of a module."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("reports.page.pictures.save", save_plainly)
        yield
