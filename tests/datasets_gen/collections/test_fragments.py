import numpy as np
import pytest

from datasets_gen import InputError, load
from datasets_gen.registry import outline
from tests.datasets_gen.collections.layout_files import egg, write_off, write_table


def written(folder):
    """A body, and two fragments of it with maps to it, one of them with an underscore in its name."""
    vertices, faces = egg()
    write_off(folder / "shapes" / "body.off", vertices, faces)
    found = {}
    for name, sign in (("tr_1", 1), ("tr_2", -1)):
        kept = faces[(sign * vertices[faces][:, :, 2] > -0.3).all(axis=1)]
        used, own = np.unique(kept, return_inverse=True)
        write_off(folder / "shapes" / f"{name}.off", egg(0.2)[0][used], own.reshape(-1, 3))
        write_table(folder / "maps" / f"{name}_body.map", used)
        found[name] = used
    return found


def test_fragments_lie_on_the_shape_that_most_maps_lead_to(tmp_path):
    used = written(tmp_path / "cp2p")
    found = load(tmp_path / "cp2p")
    assert (found.subject, found.poses, found.reference.pose) == ("cp2p", ("body", "tr_1", "tr_2"), "body")
    assert outline(tmp_path / "cp2p")["poses"] == list(found.poses)
    for name, ids in used.items():
        place = found.placements[name]
        assert np.allclose(found.reference.at(place.face_ids, place.barycentrics), egg()[0][ids])


def test_vertices_without_a_match_take_a_neighbours_place(tmp_path):
    used = written(tmp_path)
    rows = used["tr_1"].copy()
    rows[3] = -1
    write_table(tmp_path / "maps" / "tr_1_body.map", rows)
    found = load(tmp_path)
    assert any("1 vertices without a match" in remark for remark in found.remarks)
    place = found.placements["tr_1"]
    where = found.reference.at(place.face_ids, place.barycentrics)[3]
    edge = np.linalg.norm(where - egg()[0][used["tr_1"][3]])
    assert 0 < edge < 0.5


def test_another_reference(tmp_path):
    used = written(tmp_path)
    write_table(tmp_path / "maps" / "tr_1_tr_2.map", np.zeros(len(used["tr_1"])))
    assert load(tmp_path, reference="tr_2").poses == ("tr_2", "tr_1")
    with pytest.raises(InputError, match="has no shape 'x'; it has body, tr_1, tr_2"):
        load(tmp_path, reference="x")
    with pytest.raises(InputError, match=r"no map between two of the shapes that fits \(A_tr_1.map"):
        load(tmp_path, reference="tr_1")


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("0\n1\n", r"tr_1_body.map' has 2 rows, 'tr_1.off' \d+ vertices; rows are vertices of the first"),
        (None, r"names number 162 of a target of 162 points; its indices may count from 1"),
        ("0\nx\n", r"tr_1_body.map', line 2: 'x' is no number"),
    ],
)
def test_a_map_that_does_not_fit_is_refused(tmp_path, content, message):
    used = written(tmp_path)
    path = tmp_path / "maps" / "tr_1_body.map"
    if content is None:
        write_table(path, np.where(used["tr_1"] == used["tr_1"].max(), 162, used["tr_1"]))
    else:
        path.write_text(content)
    with pytest.raises(InputError, match=message) as caught:
        load(tmp_path)
    assert "\n" not in str(caught.value)


def test_triangles_and_weights_of_a_corr_file(tmp_path):
    """Middles of triangles; a vertex without a match takes a neighbour's place."""
    used = written(tmp_path)
    vertices, faces = egg()
    rows = np.array([[np.argwhere(faces == v)[0][0] + 1, 0.25, 0.5, 0.25] for v in used["tr_1"]])
    middles = np.einsum("c,ncd->nd", [0.25, 0.5, 0.25], vertices[faces[rows[:, 0].astype(int) - 1]])
    rows[3] = [-1, 0, 0, 0]
    (tmp_path / "maps" / "tr_1_body.map").unlink()
    write_table(tmp_path / "maps" / "tr_1_body.corr", rows)
    found = load(tmp_path)
    place = found.placements["tr_1"]
    where = found.reference.at(place.face_ids, place.barycentrics)
    matched = np.arange(len(rows)) != 3
    assert np.allclose(where[matched], middles[matched], atol=1e-6)
    assert np.linalg.norm(where[matched] - where[3], axis=1).min() < 1e-6
    assert any("1 vertices without a match" in remark for remark in found.remarks)
