"""Small sound files of every kind that the project reads, made by its own writers where it has them."""

import base64
import io
import json
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import trimesh
from scipy.io import savemat

from datasets_gen import Collection, Shape
from datasets_gen.meshes.files import write_mesh
from medial import Diffusion, Matching
from scanner_sim import Scan, sample
from tests.datasets_gen.collections.gltf_files import animate, turn, two_bones
from tests.datasets_gen.collections.layout_files import write_matlab, write_table

TOML = """\
name = "small"
description = "two poses"
seeds = [0, 1]
timeout = 60.0
evaluated = 100
departures = "all"

[[dataset]]
name = "human"
poses = ["walk", "sit"]
options = {proportions = 3}

[scan]
threshold = 0.3
views = "ring:4"
points = 500
scanner = {noise = 0.1, resolution = [64, 48]}
rotation = 30.0

[operators]
modes = 40
medial = {eta = 0.5, sigma_e = 5.0}

[stability]
operators = ["medial", "heat"]
sweep = {threshold = [0.3, 0.8]}
pairs = 100
times = 5

[matching]
pairs = [["walk", "sit"]]
sweep = {"source.threshold" = [0.3, 0.8], points = [200]}

[[matching.regime]]
name = "noisy"
"scanner.noise" = 0.2

[[method]]
name = "medial"
label = "medial diffusion"
samples = 50

[[method]]
name = "rigid"
options = {}
"""

PRESET = """\
[about]
name = "bench scanner"

[scanner]
resolution = [640, 480]
views = 6
peak_threshold = 0.3
noise = 0.02
distance = 200.0
"""

OBJ = b"""\
mtllib a.mtl
o body
v 0 0 0 1 0 0
v 1 0 0 1 0 0
v 0 1 0 1 0 0
v 0 0 1 0 0 1
vt 0 0
vt 1 0
vn 0 0 1
usemtl skin
f 1/1/1 3/2/1 2/1/1
f 1//1 2//1 4//1
f -3 -2 -1
f 1 4 3
"""

CLOUD_PLY = b"""\
ply
format ascii 1.0
comment TextureFile a.png
element vertex 5
property float x
property float y
property double z
property float nx
property float ny
property float nz
property uchar red
property list uchar int ids
end_header
0 0 0 0 0 1 1 2 3 4
1 0 0 0 0 1 1 2 3 4
0 1 0 0 0 1 1 2 3 4
1 1 0 0 0 1 1 2 3 4
1 1 1 0 0 1 1 1 7
"""

STRIPS_PLY = b"""\
ply
format ascii 1.0
element vertex 5
property float x
property float y
property float z
element tristrips 1
property list int int vertex_indices
end_header
0 0 0
1 0 0
0 1 0
1 1 0
1 1 1
8 0 1 2 3 -1 2 3 4
"""

NOFF = b"NOFF # by hand\n5 0 0\n" + b"".join(b"%d 0 .5 0 0 1\n" % i for i in range(5))

_ROWS = [f"{i % 3}.5 {i // 3} 0.25" for i in range(9)]
TEXTS = {
    "txt": "\n".join(["x y z nx ny nz", *(f"{row} 0 0 1" for row in _ROWS)]).encode(),
    "pts": "\n".join(["9", *(f"{row} 7 255 0 3" for row in _ROWS)]).encode(),
    "csv": "\n".join(row.replace(" ", ";").replace(".", ",") for row in _ROWS).encode(),
    "asc": "\n".join(f"{row} 9 200 3 0 0.6 0.8" for row in _ROWS).encode(),
}

XYZ = b"# x y z nx ny nz\n" + b"".join(b"%d,%d 0.5 0 0 1\n" % (i % 3, i // 3) for i in range(9))


@cache
def shape() -> Shape:
    """A ball of 42 vertices."""
    mesh = trimesh.creation.icosphere(subdivisions=1)
    return Shape(np.array(mesh.vertices), np.array(mesh.faces, np.int32), "ball", "ball", "rest")


@cache
def cloud() -> Scan:
    """Thirty points of it."""
    return sample(shape(), 30, 0)


def written(save: Callable[[Path], Any], suffix: str) -> bytes:
    """What a writer puts into a file."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / f"file{suffix}"
        save(path)
        return path.read_bytes()


def mesh_file(suffix: str, of: str = "", **options: Any) -> bytes:
    """The ball in a format, which `of` names where there are several of one suffix."""
    if not options and not of:
        return written(lambda path: write_mesh(shape(), path), suffix)
    mesh = trimesh.Trimesh(shape().vertices, shape().faces, process=False)
    content = mesh.export(file_type=of or suffix[1:], **options)
    return content if isinstance(content, bytes) else content.encode()


def collection() -> Collection:
    """The ball and a longer one."""
    rest = shape()
    tall = Shape(rest.vertices * [1, 1, 2], rest.faces, "ball/tall", "ball", "tall")
    return Collection("ball", (rest, tall), rest, np.arange(len(rest.vertices)))


def diffusion() -> Diffusion:
    """An operator that need not be one."""
    n = len(cloud())
    functions = np.full((n, 2), n**-0.5)
    return Diffusion(cloud().points, cloud().normals, np.ones(n), np.array([0.0, 1.0]), functions,
                     cloud().points * 0.5, np.ones(n), operator="medial")  # fmt: skip


def matching() -> Matching:
    """The identity."""
    n = len(cloud())
    return Matching(np.arange(n), np.array([[0, 0], [5, 5]]), 0.1, np.ones(n), {"first": np.array([0])},
                    source_points=cloud().points, target_points=cloud().points)  # fmt: skip


def gltf() -> bytes:
    """A triangle with its buffer in the text."""
    data = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0]], "<f4").tobytes() + np.arange(3, dtype="<u2").tobytes()
    uri = "data:application/octet-stream;base64," + base64.b64encode(data).decode()
    tree = {
        "asset": {"version": "2.0"},
        "scene": 0,
        "scenes": [{"nodes": [0]}],
        "nodes": [{"mesh": 0, "scale": [1, 2, 1]}],
        "meshes": [{"primitives": [{"attributes": {"POSITION": 0}, "indices": 1}]}],
        "accessors": [
            {"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"},
            {"bufferView": 1, "componentType": 5123, "count": 3, "type": "SCALAR"},
        ],
        "bufferViews": [
            {"buffer": 0, "byteOffset": 0, "byteLength": 36},
            {"buffer": 0, "byteOffset": 36, "byteLength": 6},
        ],
        "buffers": [{"byteLength": 42, "uri": uri}],
    }
    return json.dumps(tree).encode()


def character(suffix: str) -> bytes:
    """A tube of two bones, one of which turns and moves; a ``.gltf`` has its buffer in the text."""
    writer, vertices, _ = two_bones()
    animate(writer, "bend", times=[1.0, 2.0], values=[turn(0, 0), turn(0, 60)])
    moved = [[0, 1, 0]] * 9
    animate(writer, "move", path="translation", times=[0, 1, 2], values=moved, interpolation="CUBICSPLINE")
    primitive = writer.content["meshes"][0]["primitives"][0]
    primitive["targets"] = [{"POSITION": writer.add(vertices * [0.1, 0, 0])}]
    writer.content["meshes"][0]["weights"] = [0.5]
    if suffix == ".glb":
        return written(writer.write_glb, suffix)
    uri = "data:application/octet-stream;base64," + base64.b64encode(bytes(writer.data)).decode()
    return written(lambda path: writer.write_gltf(path, uri), suffix)


def tosca() -> bytes:
    """The ball as TOSCA's MATLAB files have it."""
    return written(lambda path: write_matlab(path, shape().vertices, shape().faces), ".mat")


def vert() -> bytes:
    """The vertices of the ball as text."""
    return written(lambda path: write_table(path, shape().vertices), ".vert")


def pcd(storage: str) -> bytes:
    """The cloud as a PCD file in one of its forms, packed without any copies."""
    table = np.hstack([cloud().points, cloud().normals]).astype("<f4")
    head = "VERSION 0.7\nFIELDS x y z normal_x normal_y normal_z\nSIZE 4 4 4 4 4 4\nTYPE F F F F F F\n"
    head += f"COUNT 1 1 1 1 1 1\nWIDTH {len(table)}\nHEIGHT 1\nPOINTS {len(table)}\nDATA {storage}\n"
    if storage == "ascii":
        return head.encode() + "\n".join(" ".join(map(str, row)) for row in table.tolist()).encode()
    if storage == "binary":
        return head.encode() + table.tobytes()
    data = table.T.tobytes()
    packed = b"".join(
        bytes([len(part) - 1]) + part for part in (data[k : k + 32] for k in range(0, len(data), 32))
    )
    sizes = np.array([len(packed), len(data)], "<u4").tobytes()
    return head.encode() + sizes + packed


def las(suffix: str) -> bytes:
    """The cloud as the project exports it."""
    return written(cloud().save, suffix)


def npz(**arrays: Any) -> bytes:
    """Arrays by name."""
    out = io.BytesIO()
    np.savez(out, **arrays)
    return out.getvalue()


def npy(array: Any) -> bytes:
    """One array."""
    out = io.BytesIO()
    np.save(out, array)
    return out.getvalue()


def mat_of_ids() -> bytes:
    """A map from MATLAB."""
    out = io.BytesIO()
    savemat(out, {"matches": np.array([[1.0], [3], [2]]), "C": np.eye(2)})
    return out.getvalue()


MANIFEST = json.dumps(
    {
        "format": "medialbench-collection-1",
        "subject": "ball",
        "units": "mm",
        "reference": "rest",
        "poses": [{"pose": "rest", "file": "rest.ply"}, {"pose": "tall", "file": "tall.ply"}],
    }
).encode()


@cache
def results_files() -> dict[str, bytes]:
    """A results folder as earlier versions left it, without checksums: by name of the file within it."""
    import pandas as pd

    from evaluation.results.result_files import RECORD
    from evaluation.results.table import COLUMNS

    shared = {"dataset": "ball", "subject": "ball", "views": "6", "seed": 0, "source_threshold": 0.3}
    shared |= {"regime": "threshold 0.3", "source_pose": "rest", "target_pose": "tall", "n_points": 30}
    rows = [
        {**shared, "kind": kind, "operator": operator, "method": operator, "geodesic_mean": 3.0, "eq18": 0.1,
         "matched": 1.0, "overlap": 0.9, "source_missing": 0.2, "target_missing": 0.2, "flipped": False,
         "score_key": f"{kind}-{operator}"}
        for kind in ("matching", "stability")
        for operator in ("medial", "heat")
    ]  # fmt: skip
    table = pd.DataFrame(rows, columns=list(COLUMNS)).astype(COLUMNS)
    record = dict.fromkeys(RECORD) | {
        "key": "some",
        "stage": "score",
        "info": {"row": {"eq18": 0.1}, "curve": [1, 2]},
    }
    return {
        "table.parquet": written(table.to_parquet, ".parquet"),
        "failures.csv": b"key,stage,label,kind,reason\nk,map,walk to sit,error,out of luck\n",
        "run.json": json.dumps({"format": 2, "datasets": {"ball": "k"}, "wall_seconds": 2.5}).encode(),
        "experiment.toml": TOML.encode(),
        "scores/some.json": json.dumps(record).encode(),
    }
