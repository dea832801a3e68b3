"""The readers, each as a target: sound files to start from, how they are broken, and what is sound."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cache, partial
from importlib.util import find_spec
from pathlib import Path
from random import Random
from typing import Any

import numpy as np

from datasets_gen import Collection
from datasets_gen.collections.folder import write_collection
from datasets_gen.correspondences.reading import read_map
from evaluation import Experiment
from medial import Diffusion, Matching
from scanner_sim import Scan, ScannerConfig
from tests.fuzzing import checks, readers, seeds
from tests.fuzzing.arrays import mutated_npz, mutated_parquet
from tests.fuzzing.mutations import mutated, mutated_header

Mutate = Callable[[Random, bytes, Sequence[bytes]], bytes]


def _nothing(*_given: Any) -> None:
    """For targets without preparation, or whose reader checks by itself."""


@dataclass(frozen=True, kw_only=True)
class Target:
    """A reader under test."""

    name: str
    file: str
    """Name of the file in the folder of the case."""
    seeds: Callable[[], tuple[bytes, ...]]
    read: Callable[[Path], Any]
    check: Callable[[Any], None] = _nothing
    mutate: Mutate = mutated
    tokens: tuple[bytes, ...] = ()
    slow: bool = False
    """Takes tens of milliseconds a file."""
    prepare: Callable[[Path], Any] = field(default=_nothing)
    """Puts what else the reader needs into a folder, once."""

    def warm(self, folder: Path) -> None:
        """Prepare a folder and read the sound files there: what is compiled at first use is compiled now."""
        self.prepare(folder)
        for data in _started(self):
            (folder / self.file).write_bytes(data)
            self.read(folder / self.file)

    def case(self, rng: Random) -> bytes:
        """A broken file."""
        return self.mutate(rng, rng.choice(_started(self)), self.tokens)


@cache
def _started(target: Target) -> tuple[bytes, ...]:
    return target.seeds()


def _reader_of_results(file: str, read: Callable[[Path], Any], mutate: Mutate = mutated) -> Target:
    return Target(
        name=f"results-{file.replace('.', '-').replace('/', '-')}",
        file=file,
        seeds=lambda: (seeds.results_files()[file],),
        read=read,
        mutate=mutate,
        prepare=readers.write_store,
        slow=read is readers.read_leaderboard,
    )


def _record(name: str, cls: Any, seed: Callable[[], bytes], check: Callable[[Any], None]) -> Target:
    return Target(
        name=f"record-{name}",
        file="file.npz",
        seeds=lambda: (seed(),),
        read=cls.load,
        check=check,
        mutate=mutated_npz,
    )


def _ids_file(suffix: str, content: Callable[[], bytes], mutate: Mutate = mutated) -> Target:
    return Target(
        name=f"map-of-others-{suffix}",
        file=f"a--b.{suffix}",
        seeds=lambda: (content(),),
        read=partial(read_map, otherwise=0),
        check=checks.sound_ids,
        mutate=mutate,
    )


PLY = (
    b"property list uchar int vertex_indices\n",
    b"property list float float texcoord\n",
    b"element face 3\n",
    b"element vertex 99999999999\n",
    b"format binary_big_endian 1.0\n",
    b"property double red\n",
    b"comment TextureFile ../a.png\n",
    b"end_header\n",
    b"element edge 2\n",
)
TEXT = (b"x y z\n", b"x,y,z,r,g,b\n", b"9\n", b"1,5;2,5;3,5\n", b"// x y z\n", b";", b"\xb5", b"nan ")
PCD = (b"DATA binary\n", b"DATA ascii\n", b"COUNT 9\n", b"SIZE 8\n", b"POINTS 99999999999\n", b"TYPE U\n")
MESHES = {
    "ply-binary": (".ply", lambda: (seeds.mesh_file(".ply"),), PLY),
    "ply-ascii": (".ply", lambda: (seeds.mesh_file(".ply", encoding="ascii"),), PLY),
    "obj": (
        ".obj",
        lambda: (seeds.mesh_file(".obj"), seeds.OBJ),
        (
            b"f 1 2 -9\n",
            b"f 1//2 3/4 5\n",
            b"usemtl x\n",
            b"mtllib /dev/zero\n",
            b"v 1\n",
            b"\\\n",
            b"l 1 2\n",
            b"p 1\n",
        ),
    ),
    "off": (
        ".off",
        lambda: (seeds.mesh_file(".off"), b"COFF\n" + seeds.mesh_file(".off")[3:]),
        (b"COFF\n", b"NOFF\n", b"OFF BINARY\n", b"# no\n", b"4 0 1 2 3\n"),
    ),
    "stl-binary": (".stl", lambda: (seeds.mesh_file(".stl", of="stl"),), (b"solid ", b"vertex ")),
    "stl-text": (
        ".stl",
        lambda: (seeds.mesh_file(".stl", of="stl_ascii"),),
        (b"endsolid\n", b"solid b\n", b"vertex 0 0\n", b"facet\n"),
    ),
    "glb": (".glb", lambda: (seeds.mesh_file(".glb", of="glb"),), (b'"uri":"../a.bin"', b'"skins":[]')),
    "gltf": (".gltf", lambda: (seeds.gltf(),), (b'"uri":"/dev/zero"', b'"count":9999999', b'"children":[0]')),
}
CLOUDS = {
    "ply": (".ply", lambda: (seeds.CLOUD_PLY, seeds.mesh_file(".ply")), PLY, mutated),
    "ply-scan": (".ply", lambda: (seeds.written(seeds.cloud().save, ".ply"),), PLY, mutated),
    "obj": (
        ".obj",
        lambda: (seeds.OBJ, seeds.OBJ[: seeds.OBJ.index(b"usemtl")]),
        (b"vn 1 0\n", b"vn nan 0 0\n"),
        mutated,
    ),
    "off": (".off", lambda: (seeds.mesh_file(".off"), b"OFF\n2 0 0\n0 0 1\n1 1 1\n"), (), mutated),
    "ply-strips": (".ply", lambda: (seeds.STRIPS_PLY,), PLY, mutated),
    "off-normals": (".off", lambda: (seeds.NOFF,), (b"STCNOFF 4 0 0\n", b"# no\n", b"4 1 0\n"), mutated),
    "xyz": (".xyz", lambda: (seeds.XYZ,), (b"#", b"\xef\xbb\xbf", b";", b"1e999", b"\0"), mutated),
    **{
        name: (f".{name}", lambda name=name: (seeds.TEXTS[name],), TEXT, mutated)
        for name in ("txt", "pts", "csv", "asc")
    },
    "npy": (".npy", lambda: (seeds.npy(seeds.cloud().points), seeds.npy(np.ones((4, 6)))), (), mutated),
    "npz-plain": (
        ".npz",
        lambda: (seeds.npz(points=seeds.cloud().points, normals=seeds.cloud().normals),),
        (),
        mutated_npz,
    ),
    "pcd-ascii": (".pcd", lambda: (seeds.pcd("ascii"),), PCD, mutated),
    "pcd-binary": (".pcd", lambda: (seeds.pcd("binary"),), PCD, mutated),
    "pcd-packed": (".pcd", lambda: (seeds.pcd("binary_compressed"),), PCD, mutated),
    **{
        name: (f".{name}", lambda name=name: (seeds.las(f".{name}"),), (), change)
        for name, change in (("las", mutated), ("laz", mutated_header))
        if find_spec("laspy") and find_spec("lazrs")
    },
    "npz": (
        ".npz",
        lambda: (seeds.written(seeds.cloud().save, ".npz"), seeds.written(seeds.shape().save, ".npz")),
        (),
        mutated_npz,
    ),
}

TARGETS = {
    target.name: target
    for target in (
        *(
            Target(
                name=f"mesh-{name}",
                file=f"file{suffix}",
                seeds=start,
                read=readers.read_mesh,
                tokens=tokens,
                check=checks.sound_shape,
            )
            for name, (suffix, start, tokens) in MESHES.items()
        ),
        *(
            Target(
                name=f"cloud-{name}",
                file=f"file{suffix}",
                seeds=start,
                read=readers.read_points,
                prepare=readers.compile_normals,
                tokens=tokens,
                check=checks.sound_cloud,
                mutate=mutate,
            )
            for name, (suffix, start, tokens, mutate) in CLOUDS.items()
        ),
        _record("scan", Scan, lambda: seeds.written(seeds.cloud().save, ".npz"), checks.sound_scan),
        _record(
            "collection",
            Collection,
            lambda: seeds.written(seeds.collection().save, ".npz"),
            checks.sound_collection,
        ),
        _record(
            "diffusion",
            Diffusion,
            lambda: seeds.written(seeds.diffusion().save, ".npz"),
            checks.sound_diffusion,
        ),
        _record("map", Matching, lambda: seeds.written(seeds.matching().save, ".npz"), checks.sound_matching),
        Target(
            name="manifest",
            file="manifest.json",
            seeds=lambda: (seeds.MANIFEST,),
            read=readers.read_folder,
            check=checks.sound_collection,
            prepare=lambda folder: write_collection(seeds.collection(), folder),
            tokens=(b"../", b"/etc/passwd", b"\\u0000", b"\\ud800", b"[" * 3000),
        ),
        *(
            Target(
                name=f"character-{suffix}",
                file=f"file.{suffix}",
                seeds=lambda suffix=suffix: (seeds.character(f".{suffix}"),),
                read=readers.read_character,
                check=checks.sound_collection,
                tokens=(
                    b'"uri":"/dev/zero"',
                    b'"count":9999999',
                    b'"children":[0]',
                    b'"skin":7',
                    b'"sparse":{}',
                    b'"STEP"',
                    b'"scale"',
                    b'"extensionsRequired":["KHR_draco_mesh_compression"],',
                ),
            )
            for suffix in ("glb", "gltf")
        ),
        *(
            Target(
                name=f"layout-{name}",
                file=file,
                seeds=lambda start=start: (start(),),
                read=readers.read_layout,
                check=check,
                prepare=prepare,
            )
            for name, file, start, prepare, check in (
                ("mat", "cat1.mat", seeds.tosca, readers.write_tosca, checks.sound_collection),
                ("vert", "cat1.vert", seeds.vert, readers.write_vert, checks.sound_collection),
                (
                    "frames",
                    "frame_1.obj",
                    partial(seeds.mesh_file, ".obj"),
                    readers.write_frame,
                    checks.sound_shapes,
                ),
            )
        ),
        Target(
            name="experiment",
            file="file.toml",
            seeds=lambda: (seeds.TOML.encode(),),
            read=Experiment.load,
            check=lambda found: Experiment.from_table(found.as_dict()),
            tokens=(
                b"poses = 10",
                b"\n[[method]]\nname='heat'\n",
                b"[" * 3000,
                b"a = " + b"[" * 3000,
                b"a = 1979-05-27",
                b"views = -1",
            ),
        ),
        Target(
            name="scanner-preset",
            file="file.toml",
            seeds=lambda: (seeds.PRESET.encode(),),
            read=ScannerConfig.preset,
            tokens=(b"noise = " + b"[" * 3000, b"cameras = 2\n", b"views = [[0,0,1]]\n", b"preset = 'x'\n"),
        ),
        Target(
            name="set-options",
            file="options.txt",
            seeds=lambda: (
                b"noise=.5\nviews=ring:4",
                b"as=method\nname=medial\nsettings={samples=50, times=7}",
                b"as=method\nname=cpd\nname=rigid",
                b"resolution=[64, 48]\nmaterial=skin",
            ),
            read=readers.read_options,
            tokens=(b"=[[", b"={a=1}", b"1e999", b"=nan", b"\0", b"[" * 3000),
        ),
        _ids_file(
            "npz", lambda: seeds.npz(source_to_target=np.arange(5), confidence=np.ones(5)), mutated_npz
        ),
        _ids_file("npy", lambda: seeds.npy(np.arange(5))),
        _ids_file("txt", lambda: b"0 1.0\n1 .5\n-1 0\n"),
        _ids_file("csv", lambda: b"0,1.0\n1,.5\n-1,0\n"),
        _ids_file("csv.csv", lambda: b"# first_id = 1\nsource,target,confidence\n1,2,.5\n2,-1,0\n"),
        _ids_file("map", lambda: b"0\n2\n1\n"),
        _ids_file("baryc_gt", lambda: b"1 .5 .25 .25\n4 1 0 0\n"),
        _ids_file("vts", lambda: b"1\n3\n2\n"),
        _ids_file("corr", lambda: b"1 .5 .25 .25\n-1 0 0 0\n4 1 0 0\n"),
        _ids_file("mat", seeds.mat_of_ids),
        _reader_of_results("table.parquet", readers.read_leaderboard, mutated_parquet),
        _reader_of_results("run.json", readers.read_notes),
        _reader_of_results("failures.csv", readers.read_notes),
        _reader_of_results("experiment.toml", readers.read_leaderboard),
        _reader_of_results("scores/some.json", readers.read_score),
    )
}
"""By name."""
