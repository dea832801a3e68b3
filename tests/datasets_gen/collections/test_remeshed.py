import numpy as np
import pytest

from datasets_gen import InputError, load
from datasets_gen.registry import outline
from tests.datasets_gen.collections.layout_files import egg, write_off, write_table


def written(folder, names=("mesh000", "mesh001"), base=1):
    """Shapes whose vertices are those of a template in another order each; the order of each shape."""
    orders = {}
    for number, name in enumerate(names):
        vertices, faces = egg(0.1 * number)
        order = np.random.default_rng(number).permutation(len(vertices))  # template point of each vertex
        place = np.argsort(order)
        write_off(folder / "off" / f"{name}.off", vertices[order], place[faces])
        write_table(folder / "corres" / f"{name}.vts", place + base)
        orders[name] = order
    return orders


def test_shapes_lie_on_the_first_by_the_template(tmp_path):
    orders = written(tmp_path)
    shapes = load(tmp_path)
    assert (shapes.poses, shapes.reference.pose) == (("mesh000", "mesh001"), "mesh000")
    assert outline(tmp_path) == {"subject": "mesh", "poses": list(shapes.poses), "reference": "mesh000"}
    place = shapes.placements["mesh001"]
    corners = shapes.reference.at(place.face_ids, place.barycentrics)
    assert np.allclose(corners, egg()[0][orders["mesh001"]])
    assert list(load(tmp_path, reference="mesh001").placements) == ["mesh000"]


def test_meshes_may_lie_beside_their_maps(tmp_path):
    orders = written(tmp_path)
    inside = load(tmp_path)
    for file in (tmp_path / "off").iterdir():
        file.rename(tmp_path / file.name)
    (tmp_path / "off").rmdir()
    beside = load(tmp_path)
    for pose in orders:
        assert np.array_equal(beside[pose].vertices, inside[pose].vertices)
    assert np.array_equal(beside.placements["mesh001"].face_ids, inside.placements["mesh001"].face_ids)


def test_a_vertex_of_no_template_point_takes_its_nearest_neighbours_place(tmp_path):
    orders = written(tmp_path)
    rows = [np.loadtxt(tmp_path / "corres" / f"{name}.vts", dtype=int) for name in orders]
    left = 5  # template point that is taken away
    for name, row in zip(orders, rows, strict=True):
        write_table(tmp_path / "corres" / f"{name}.vts", np.delete(row, left))
    shapes = load(tmp_path)
    place = shapes.placements["mesh001"]
    vertices, faces = egg(0.1)
    around = np.setdiff1d(faces[(faces == left).any(axis=1)], [left])
    nearest = around[np.linalg.norm(vertices[around] - vertices[left], axis=1).argmin()]
    vertex = rows[1][left] - 1
    found = shapes.reference.at(place.face_ids[[vertex]], place.barycentrics[[vertex]])
    assert np.allclose(found, egg()[0][nearest])
    assert any("1 vertices of no template point" in remark for remark in shapes.remarks)


def test_the_mirror_images_come_from_the_files_of_the_reference(tmp_path):
    orders = written(tmp_path)
    place = np.argsort(orders["mesh000"])
    image = np.random.default_rng(9).permutation(162)  # template point at the mirror image of each
    write_table(tmp_path / "corres" / "mesh000.sym.vts", place[image] + 1)
    assert np.array_equal(load(tmp_path).mirror[place], place[image])
    assert load(tmp_path, reference="mesh001").mirror is None  # an egg without symmetry


def test_classes_are_told_apart(tmp_path):
    written(tmp_path, ("cat0", "cat10", "cat2", "dog1"))
    with pytest.raises(InputError, match="several subjects: cat, dog"):
        load(tmp_path)
    assert load(tmp_path, subject="cat").poses == ("cat0", "cat2", "cat10")


def test_indices_from_0_are_refused(tmp_path):
    written(tmp_path, base=0)
    with pytest.raises(InputError, match=r"mesh000.vts': row \d+ names no vertex; a .vts counts from 1"):
        load(tmp_path)


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (None, r"mesh001.vts' is missing"),
        ("1\n2\n", r"mesh001'.vts has 2 rows, mesh000.vts 162; rows are the points of one template"),
        ("163\n", r"mesh001.vts' names vertex 163 of 162; rows are template points and entries vertices"),
        ("1\none\n", r"mesh001.vts', line 2: 'one' is no number"),
        ("1 2 3\n", r"mesh001.vts.*3 columns without names; give an index per line"),
    ],
)
def test_a_map_that_does_not_fit_is_refused(tmp_path, content, message):
    written(tmp_path)
    path = tmp_path / "corres" / "mesh001.vts"
    if content is None:
        path.unlink()
    else:
        path.write_text(content)
    with pytest.raises(InputError, match=message) as caught:
        load(tmp_path)
    assert "\n" not in str(caught.value)
