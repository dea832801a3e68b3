"""Characters of glTF files: a tube of two bones whose posed vertices are known in closed form."""

import base64
import json

import numpy as np
import pytest
import trimesh

from datasets_gen import InputError
from datasets_gen.registry import load, outline
from tests.datasets_gen.collections.gltf_files import Writer, animate, tube, turn, two_bones


def bent(vertices, degrees):
    """The tube with what lies above y = 1 turned about the x axis through (0, 1, 0)."""
    angle = np.radians(degrees)
    x, y, z = (vertices - [0, 1, 0]).T
    turned = np.column_stack(
        [x, y * np.cos(angle) - z * np.sin(angle), y * np.sin(angle) + z * np.cos(angle)]
    )
    return np.where(vertices[:, [1]] > 1 + 1e-6, turned + np.array([0, 1, 0]), vertices)


def bending(path, **options):
    writer, vertices, _ = two_bones(**options)
    animate(writer, "bend", times=[1.0, 2.0], values=[turn(0, 0), turn(0, 60)])
    return writer.write_glb(path), vertices


def test_poses_are_those_of_the_skin_at_even_times(tmp_path):
    path, vertices = bending(tmp_path / "tube.glb")
    found = load(path, frames=4)
    assert found.subject == "tube"
    assert found.poses == ("rest", "bend-1", "bend-2", "bend-3", "bend-4")
    assert found.reference is found["rest"]
    assert found["rest"].units == "m"
    assert found["rest"].vertices == pytest.approx(vertices, abs=1e-6)
    for pose, degrees in (("bend-1", 0), ("bend-2", 20), ("bend-3", 40), ("bend-4", 60)):
        assert found[pose].vertices == pytest.approx(bent(vertices, degrees), abs=1e-6), pose
    assert trimesh.Trimesh(found["bend-4"].vertices, found.reference.faces, process=False).is_watertight
    assert np.array_equal(found["bend-4"].faces, found.reference.faces)


def test_the_outline_agrees_and_options_choose(tmp_path):
    path, _ = bending(tmp_path / "tube.glb")
    assert outline(path)["poses"] == ["rest", *(f"bend-{k}" for k in range(1, 9))]
    told = outline(path, frames=2, poses=["bend-2"])
    assert told == {"subject": "tube", "poses": ["bend-2"], "reference": "rest"}
    found = load(path, frames=2, poses=["bend-2"])
    assert (found.poses, found.reference.pose) == (("bend-2",), "rest")
    for options, why in (
        ({"frames": 0}, "frames of 'tube' is 0"),
        ({"frames": 2000}, "at most 1000"),
        ({"animations": ["run"]}, "no animations 'run'; give a list of"),
        ({"animations": "bend"}, "give a list"),
        ({"poses": ["bend-9"]}, "no pose 'bend-9'"),
    ):
        with pytest.raises(InputError, match=why):
            outline(path, **options)


def test_seams_are_welded_where_vertices_move_alike_and_it_is_said(tmp_path):
    """Every face has corners of its own, 432 in all; the closed tube has 74 places."""
    path, _ = bending(tmp_path / "tube.glb", split=True)
    found = load(path, frames=2)
    vertices, faces = tube()
    assert found.reference.vertices.shape == vertices.shape
    assert found.reference.faces.shape == faces.shape
    assert trimesh.Trimesh(found.reference.vertices, found.reference.faces, process=False).is_watertight
    assert any(f"{faces.size - len(vertices)} vertices along seams" in each for each in found.remarks)
    assert any("closed, one piece, genus 0" in each for each in found.remarks)


def test_vertices_at_one_place_that_move_otherwise_stay_apart(tmp_path):
    """Half of the corners on the ring at y = 1 follow the other bone: welding would tear the poses."""
    writer, vertices, faces = two_bones(split=True)
    share = (vertices[faces].mean(axis=1)[:, 1] > 1).repeat(3).astype(float)
    primitive = writer.content["meshes"][0]["primitives"][0]
    primitive["attributes"]["WEIGHTS_0"] = writer.add(
        np.column_stack([1 - share, share, 0 * share, 0 * share])
    )
    animate(writer, "bend", times=[0.0, 1.0], values=[turn(0, 0), turn(0, 60)])
    found = load(writer.write_glb(tmp_path / "cut.glb"), frames=2)
    assert any("2 pieces: the largest is kept" in each for each in found.remarks)


@pytest.mark.parametrize("kind", ["LINEAR", "STEP", "CUBICSPLINE"])
def test_translations_follow_their_interpolation(tmp_path, kind):
    """Keys at 0, 1 and 2 s, sampled every 0.5 s; the spline is level but before the second key."""
    writer, vertices, _ = two_bones()
    keys = np.array([[0, 1, 0], [0, 2, 0], [0, 4, 0]], dtype=float)
    values = keys
    if kind == "CUBICSPLINE":
        slope = np.array([0, 4.0, 0])
        values = np.concatenate([[0 * slope, keys[0], 0 * slope], [slope, keys[1], 0 * slope],
                                 [0 * slope, keys[2], 0 * slope]])  # fmt: skip
    animate(writer, "rise", path="translation", times=[0, 1, 2], values=values, interpolation=kind)
    found = load(writer.write_glb(tmp_path / "rising.glb"), frames=5)
    top = vertices[:, 1].argmax()
    heights = [found[f"rise-{k}"].vertices[top, 1] - 2 for k in range(1, 6)]
    expected = {
        "LINEAR": [0, 0.5, 1, 2, 3],
        "STEP": [0, 0, 1, 1, 3],
        "CUBICSPLINE": [0, 0.5 - 4 / 8, 1, 2, 3],  # h01(1/2) = 1/2, h11(1/2) = -1/8
    }[kind]
    assert heights == pytest.approx(expected, abs=1e-6)


def test_rotations_take_the_shorter_way_and_may_be_normalised_integers(tmp_path):
    """A quaternion and its negative are one rotation; 16 bits hold it to 3e-5."""
    writer, vertices, _ = two_bones()
    values = np.round(32767 * np.array([turn(0, 0), -np.array(turn(0, 80))])).astype(int)
    animate(writer, "bend", times=[0, 1], values=values, kind=("int16",))
    found = load(writer.write_glb(tmp_path / "tube.glb"), frames=3)
    assert found["bend-2"].vertices == pytest.approx(bent(vertices, 40), abs=1e-3)


def test_the_end_of_a_loop_is_left_out(tmp_path):
    writer, vertices, _ = two_bones()
    animate(writer, "nod", times=[0, 1, 2], values=[turn(0, 0), turn(0, 40), turn(0, 0)])
    found = load(writer.write_glb(tmp_path / "tube.glb"), frames=4)
    for pose, degrees in (("nod-1", 0), ("nod-2", 20), ("nod-3", 40), ("nod-4", 20)):
        assert found[pose].vertices == pytest.approx(bent(vertices, degrees), abs=1e-6), pose


def test_nodes_above_the_bones_and_matrices_move_them(tmp_path):
    """A parent that scales by 2 and shifts; that of the mesh itself does not count, says the format."""
    writer, vertices, _ = two_bones()
    matrix = np.diag([2.0, 2.0, 2.0, 1.0])
    matrix[:3, 3] = 3, 0, 0
    writer.content["nodes"] += [{"matrix": matrix.T.ravel().tolist(), "children": [1]}]
    writer.content["nodes"][0]["translation"] = [9, 9, 9]
    writer.content["scenes"] = [{"nodes": [0, 3]}]
    found = load(writer.write_glb(tmp_path / "tube.glb"))
    assert found.poses == ("rest",)
    assert found["rest"].vertices == pytest.approx(2 * vertices + [3, 0, 0], abs=1e-6)
    assert any("no animations" in each for each in found.remarks)


def test_rigid_parts_and_primitives_are_joined(tmp_path):
    """Two halves of a tube as two primitives of a mesh without a skin, moved by its node."""
    vertices, faces = tube()
    writer = Writer()
    position = writer.add(vertices)
    halves = [faces[: len(faces) // 2], faces[len(faces) // 2 :]]
    writer.content |= {
        "nodes": [{"mesh": 0}],
        "scenes": [{"nodes": [0]}],
        "meshes": [
            {"primitives": [
                {"attributes": {"POSITION": position}, "indices": writer.add(half.ravel(), "uint32")}
                for half in halves
            ]}
        ],
        "animations": [],
    }  # fmt: skip
    animate(writer, "roll", node=0, times=[0, 1], values=[turn(1, 0), turn(1, 90)])
    found = load(writer.write_glb(tmp_path / "rigid.glb"), frames=2)
    x, y, z = vertices.T
    order = [int(np.linalg.norm(vertices - each, axis=1).argmin()) for each in found["rest"].vertices]
    assert found["roll-2"].vertices == pytest.approx(np.column_stack([z, y, -x])[order], abs=1e-6)
    assert len(found.reference.faces) == len(faces)
    assert any("2 primitives joined" in each for each in found.remarks)


def test_morph_targets_add_up_with_their_weights(tmp_path):
    writer, vertices, _ = two_bones()
    mesh = writer.content["meshes"][0]
    wider, longer = vertices * [0.5, 0, 0], vertices * [0, 1, 0]
    mesh["primitives"][0]["targets"] = [{"POSITION": writer.add(wider)}, {"POSITION": writer.add(longer)}]
    mesh["weights"] = [0.0, 0.25]
    animate(writer, "swell", node=0, path="weights", times=[0, 1], values=[0, 0, 1, 0.5])
    found = load(writer.write_glb(tmp_path / "tube.glb"), frames=3)
    assert found["rest"].vertices == pytest.approx(vertices + 0.25 * longer, abs=1e-6)
    assert found["swell-2"].vertices == pytest.approx(vertices + 0.5 * wider + 0.25 * longer, abs=1e-6)


def test_small_holes_are_filled_and_said(tmp_path):
    writer, _, faces = two_bones()
    open_end = faces[~(faces == faces.max()).any(axis=1)]
    writer.content["meshes"][0]["primitives"][0]["indices"] = writer.add(open_end.ravel(), "uint16")
    path = writer.write_glb(tmp_path / "tube.glb")
    found = load(path)
    assert trimesh.Trimesh(found.reference.vertices, found.reference.faces, process=False).is_watertight
    assert any("1 holes, the longest rim of 8 edges: filled with 6 faces" in each for each in found.remarks)
    assert any("left open" in each for each in load(path, fill=False).remarks)


def finned(path, vertices, faces):
    """A rigid mesh in a file, with one more face on its first edge."""
    writer = Writer()
    every = np.concatenate([faces, [[*faces[0][:2], len(vertices) - 1]]])
    attributes = {"POSITION": writer.add(vertices)}
    primitive = {"attributes": attributes, "indices": writer.add(every.ravel(), "uint16")}
    writer.content |= {"nodes": [{"mesh": 0}], "meshes": [{"primitives": [primitive]}]}
    return writer.write_glb(path)


def test_few_faces_at_crowded_edges_are_cut_out_and_many_refused(tmp_path):
    """The faces around a third face's edge are 1 % of a fine ball and a tenth of a coarse tube."""
    ball = trimesh.creation.icosphere(subdivisions=3)
    found = load(finned(tmp_path / "ball.glb", ball.vertices, ball.faces))
    assert any("at edges of more than two faces: cut out" in each for each in found.remarks)
    assert trimesh.Trimesh(found.reference.vertices, found.reference.faces, process=False).is_watertight
    with pytest.raises(InputError, match="edges of more than two faces all over"):
        load(finned(tmp_path / "tube.glb", *tube()))


def test_strips_fans_strides_and_sparse_accessors(tmp_path):
    """A tetrahedron: two faces as a strip, two as a fan; interleaved vertices, one put right sparsely."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]], dtype=np.float32)
    writer = Writer()
    moved = corners.copy()
    moved[3] = 7
    interleaved = writer.view(np.column_stack([moved, 0 * moved]).astype("<f4").tobytes(), byteStride=24)
    sparse = {
        "count": 1,
        "indices": {"bufferView": writer.view(np.array([3], "<u2").tobytes()), "componentType": 5123},
        "values": {"bufferView": writer.view(corners[[3]].tobytes())},
    }
    position = writer.accessor(interleaved, 5126, 4, "VEC3", sparse=sparse)
    parts = [(5, [0, 2, 1, 3]), (6, [3, 2, 0, 1])]
    writer.content |= {
        "nodes": [{"mesh": 0}],
        "meshes": [
            {"primitives": [
                {"attributes": {"POSITION": position}, "mode": mode, "indices": writer.add(ids, "uint8")}
                for mode, ids in parts
            ]}
        ],
    }  # fmt: skip
    found = load(writer.write_glb(tmp_path / "four.glb"))
    mesh = trimesh.Trimesh(found.reference.vertices, found.reference.faces, process=False)
    assert mesh.is_watertight
    assert mesh.is_winding_consistent
    assert mesh.volume == pytest.approx(1 / 6)
    assert sorted(map(tuple, found.reference.vertices.tolist())) == sorted(map(tuple, corners.tolist()))


@pytest.mark.parametrize("uri", ["tube%20data.bin", "data:application/octet-stream;base64,"])
def test_a_gltf_has_its_data_beside_or_within(tmp_path, uri):
    writer, vertices, _ = two_bones()
    if uri.startswith("data:"):
        uri += base64.b64encode(writer.data).decode()
    path = writer.write_gltf(tmp_path / "tube.gltf", uri.replace("%20", " "))
    content = json.loads(path.read_text())
    content["buffers"][0]["uri"] = uri
    path.write_text(json.dumps(content))
    assert load(path)["rest"].vertices == pytest.approx(vertices, abs=1e-6)
    if not uri.startswith("data:"):
        (tmp_path / "tube data.bin").unlink()
        with pytest.raises(InputError, match=r"keeps its data in 'tube data.bin', which cannot be read"):
            load(path)


def draco(writer):
    writer.content["extensionsRequired"] = ["KHR_draco_mesh_compression"]


def optional_draco(writer):
    writer.content["meshes"][0]["primitives"][0]["extensions"] = {"KHR_draco_mesh_compression": {}}


def meshopt(writer):
    writer.content["bufferViews"][0]["extensions"] = {"EXT_meshopt_compression": {}}


def other_version(writer):
    writer.content["asset"]["version"] = "1.0"


def cyclic(writer):
    writer.content["nodes"][2]["children"] = [1]


def beyond(writer):
    writer.content["accessors"][0]["count"] = 10**6


def lost_joint(writer):
    writer.content["skins"][0]["joints"] = [1]


def no_type(writer):
    del writer.content["accessors"][0]["type"]


def no_mesh(writer):
    writer.content["scenes"] = [{"nodes": [1]}]


def no_triangle(writer):
    writer.content["meshes"][0]["primitives"][0]["indices"] = writer.add([0, 1], "uint16")


def flat(writer):
    writer.content["meshes"][0]["primitives"][0]["indices"] = writer.add([0, 1, 1], "uint16")


def no_turn(writer):
    animate(writer, "bend", times=[1.0, 2.0], values=[[0, 0, 0, 0], turn(0, 60)])


def no_list(writer):
    writer.content["nodes"] = 7


def outside(writer):
    writer.content["meshes"][0]["primitives"][0]["indices"] = writer.add([0, 1, 999], "uint16")


def pointer(writer):
    animate(writer, "blink", path="pointer", times=[0, 1], values=[turn(0, 0), turn(0, 1)])


@pytest.mark.parametrize(
    ("spoil", "why"),
    [
        (draco, "needs the glTF extension KHR_draco_mesh_compression"),
        (optional_draco, "glTF extension KHR_draco_mesh_compression"),
        (meshopt, "glTF extension EXT_meshopt_compression"),
        (other_version, "no glTF 2 .version '1.0'."),
        (cyclic, "a node is in it twice"),
        (beyond, "accessor 0 is damaged .it reaches beyond its buffer view"),
        (lost_joint, "joint 1 of 1"),
        (no_type, "accessor 0 is damaged .'type' is missing"),
        (no_mesh, "no mesh of triangles"),
        (no_triangle, "no mesh of triangles"),
        (flat, "no mesh of triangles"),
        (no_turn, "animation 'bend' is damaged .a rotation of four zeros"),
        (no_list, "nodes is no list"),
        (outside, "a face names vertex 999 of 74"),
        (pointer, "animates 'pointer'"),
    ],
    ids=lambda each: getattr(each, "__name__", None),
)
def test_what_cannot_be_read_is_refused_by_name(tmp_path, spoil, why):
    writer, _, _ = two_bones()
    spoil(writer)
    with pytest.raises(InputError, match=why) as caught:
        load(writer.write_glb(tmp_path / "tube.glb"))
    assert "\n" not in str(caught.value)


def test_a_file_that_is_cut_short_is_refused(tmp_path):
    path, _ = bending(tmp_path / "tube.glb")
    path.write_bytes(path.read_bytes()[:-100])
    with pytest.raises(InputError, match="cut short"):
        load(path)
