import numpy as np
import pytest

from datasets_gen import InputError, check_mesh, load_mesh, write_mesh
from datasets_gen.meshes.files import read_mesh
from tests.datasets_gen.sample_meshes import shuffled, sphere

MESH = shuffled(sphere(2))


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".off", ".PLY"])
def test_order_of_vertices_and_faces_survives(tmp_path, suffix):
    path = tmp_path / f"mesh{suffix}"
    write_mesh(MESH, path)
    for found in (read_mesh(path), load_mesh(path)):
        assert found.vertices == pytest.approx(MESH.vertices, abs=1e-6)
        assert np.array_equal(found.faces, MESH.faces)
        assert found.vertices.dtype == np.float64
        assert found.faces.dtype == np.int32
        assert (found.name, found.subject, found.pose) == ("mesh", "mesh", "mesh")


def obj_lines(face):
    return [
        *(f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in MESH.vertices),
        *(face(i, f + 1) for i, f in enumerate(MESH.faces)),
    ]


def test_order_survives_in_obj_with_texture_and_normals(tmp_path):
    """Corners with their own texture coordinates tempt a loader to split or reorder vertices."""
    uv = [f"vt {i % 7 / 7} {i % 5 / 5}" for i in range(3 * len(MESH.faces))]
    normals = [f"vn {x} {y} {z}" for x, y, z in MESH.vertices[::-1]]
    faces = obj_lines(lambda i, f: "f " + " ".join(f"{v}/{3 * i + k + 1}/{f[0]}" for k, v in enumerate(f)))
    path = tmp_path / "textured.obj"
    path.write_text("\n".join(["mtllib none.mtl", *uv, *normals, *faces]))
    found = load_mesh(path)
    assert found.vertices == pytest.approx(MESH.vertices, abs=1e-6)
    assert np.array_equal(found.faces, MESH.faces)


def test_order_survives_in_obj_with_groups_and_materials(tmp_path):
    def face(i, f):
        head = f"o part{i}\ng group{i}\nusemtl m{i % 3}\n" if i % 40 == 0 else ""
        return head + "f " + " ".join(map(str, f))

    path = tmp_path / "groups.obj"
    path.write_text("\n".join(obj_lines(face)))
    found = load_mesh(path)
    assert found.vertices == pytest.approx(MESH.vertices, abs=1e-6)
    assert np.array_equal(found.faces, MESH.faces)


def test_ascii_ply_with_colours_and_extra_properties(tmp_path):
    path = tmp_path / "ascii.ply"
    colours = [f"property uchar {name}" for name in ("red", "green", "blue")]
    header = [
        "ply",
        "format ascii 1.0",
        "comment by hand",
        f"element vertex {len(MESH.vertices)}",
        *(f"property float {axis}" for axis in "xyz"),
        *colours,
        "property float quality",
        f"element face {len(MESH.faces)}",
        "property list uchar int vertex_indices",
        "end_header",
    ]
    rows = [f"{x:.9g} {y:.9g} {z:.9g} 10 20 30 0.5" for x, y, z in MESH.vertices]
    faces = ["3 " + " ".join(map(str, f)) for f in MESH.faces]
    path.write_text("\n".join([*header, *rows, *faces]) + "\n")
    found = load_mesh(path)
    assert found.vertices == pytest.approx(MESH.vertices, abs=1e-6)
    assert np.array_equal(found.faces, MESH.faces)


def test_quadrilaterals_are_cut_alike_in_every_pose(tmp_path):
    corners = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    quads = [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]
    found = []
    for pose, stretch in (("a", (1, 1, 1)), ("b", (1, 5, 0.2))):
        lines = [f"v {x} {y} {z}" for x, y, z in corners * stretch]
        lines += ["f " + " ".join(str(v + 1) for v in quad) for quad in quads]
        (tmp_path / f"{pose}.obj").write_text("\n".join(lines))
        found.append(load_mesh(tmp_path / f"{pose}.obj"))
    assert np.array_equal(found[0].faces, found[1].faces)
    assert len(found[0].faces) == 12
    assert check_mesh(found[0]) == ()


def test_saved_shape_is_loaded(tmp_path):
    MESH.save(tmp_path / "shape.npz")
    found = load_mesh(tmp_path / "shape.npz")
    assert np.array_equal(found.vertices, MESH.vertices)
    assert found.name == MESH.name


@pytest.mark.parametrize("name", ["mesh.3ds", "mesh.txt", "mesh"])
def test_other_file_types_are_refused(tmp_path, name):
    (tmp_path / name).write_text("solid")
    with pytest.raises(InputError, match=r"\.ply, \.obj, \.off"):
        load_mesh(tmp_path / name)
    with pytest.raises(InputError, match=r"\.ply, \.obj, \.off"):
        write_mesh(MESH, tmp_path / "out" / name)
    assert not (tmp_path / "out").exists()


def test_missing_file_and_folder(tmp_path):
    with pytest.raises(InputError, match="does not exist"):
        load_mesh(tmp_path / "none.ply")
    (tmp_path / "dir.ply").mkdir()
    with pytest.raises(InputError, match="is a folder"):
        load_mesh(tmp_path / "dir.ply")
    with pytest.raises(InputError, match="does not exist"):
        load_mesh(tmp_path / "none.npz")


@pytest.mark.parametrize("suffix", [".ply", ".obj", ".off"])
@pytest.mark.parametrize("content", [b"", b"not a mesh\n", bytes(range(256)) * 4, b"ply\nformat ascii 1.0\n"])
def test_broken_files_are_refused_in_one_line(tmp_path, suffix, content):
    path = tmp_path / f"broken{suffix}"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        load_mesh(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("suffix", [".ply", ".off"])
def test_files_cut_short_are_refused(tmp_path, suffix):
    path = tmp_path / f"cut{suffix}"
    write_mesh(MESH, path)
    path.write_bytes(path.read_bytes()[: path.stat().st_size // 2])
    with pytest.raises(InputError):
        load_mesh(path)


def test_point_cloud_is_refused(tmp_path):
    path = tmp_path / "cloud.ply"
    rows = "\n".join(f"{x} {y} {z}" for x, y, z in MESH.vertices)
    head = f"ply\nformat ascii 1.0\nelement vertex {len(MESH.vertices)}\n"
    path.write_text(head + "property float x\nproperty float y\nproperty float z\nend_header\n" + rows + "\n")
    with pytest.raises(InputError, match="no faces"):
        load_mesh(path)


def test_unusable_mesh_is_refused_and_can_be_repaired(tmp_path):
    path = tmp_path / "twins.off"
    count = len(MESH.vertices)
    vertices = np.concatenate([MESH.vertices, MESH.vertices + 5])
    faces = np.concatenate([MESH.faces, MESH.faces[:-1] + count])
    lines = ["OFF", f"{len(vertices)} {len(faces)} 0", *(f"{x} {y} {z}" for x, y, z in vertices)]
    path.write_text("\n".join([*lines, *("3 " + " ".join(map(str, f)) for f in faces)]) + "\n")
    with pytest.raises(InputError, match="2 components"):
        load_mesh(path)
    assert len(load_mesh(path, repair=True).vertices) == count


def test_writing_into_a_file_as_if_it_were_a_folder(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write"):
        write_mesh(MESH, tmp_path / "file" / "mesh.ply")


def test_obj_faces_that_count_backwards_are_understood(tmp_path):
    """As the format allows: -1 is the last vertex before the face."""
    file = tmp_path / "backwards.obj"
    file.write_text(
        "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf -3/-1 -1/-1 -2/-1\nv 0 0 1\n"
        "f -4//-1 -3 -1\nf 1 -1 3\nf -3 -2 -1\n"
    )
    assert load_mesh(file).faces.tolist() == [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
