from dataclasses import replace

import numpy as np
import pytest

from datasets_gen import InputError
from datasets_gen.collections.sound_poses import sound_poses
from tests.datasets_gen.collections.layout_files import egg
from tests.datasets_gen.sample_meshes import shape


def test_what_is_found_is_said_and_all_poses_change_alike():
    vertices, faces = egg()
    inward = np.concatenate([faces, faces[[3]]])[:, ::-1]
    first = shape(np.concatenate([vertices, [[9, 9, 9]]]), inward, "a")
    second = replace(first, vertices=2 * first.vertices, name="b")
    (a, b), kept, remarks = sound_poses([first, second], fill=True)
    assert np.array_equal(kept, np.arange(162))
    assert np.array_equal(a.faces, b.faces)
    assert np.allclose(b.vertices, 2 * vertices)
    assert a.faces.shape == (320, 3)
    told = "\n".join(remarks)
    for words in ("1 faces repeat others", "1 vertices belong to no face", "faces looked inward: flipped"):
        assert f"a: {words}" in told


@pytest.mark.parametrize(("size", "unit"), [(1.8, "m"), (180, "cm"), (1800, "mm")])
def test_a_unit_is_guessed_from_the_size_of_a_body(size, unit):
    vertices, faces = egg()
    body = shape(vertices * size / np.linalg.norm(np.ptp(vertices, axis=0)), faces, "a")
    assert sound_poses([body], fill=False)[2][0].endswith(f"of unknown units; perhaps {unit}")
    known = replace(body, units="mm")
    assert sound_poses([known], fill=False)[2][0].endswith(" mm")


def test_a_large_hole_is_left_open():
    """More edges than the rim of an eye has."""
    count = 80
    angle = 2 * np.pi * np.arange(count) / count
    rim = np.column_stack([np.cos(angle), np.sin(angle), 0 * angle])
    k = np.arange(count)
    cone = np.column_stack([k, np.roll(k, -1), np.full(count, count)])
    mesh = shape(np.concatenate([rim, [[0, 0, 1.0]]]), cone, "a")
    (found,), _, remarks = sound_poses([mesh], fill=True)
    assert len(found.faces) == count
    assert "a: 1 holes, the longest rim of 80 edges: left open" in remarks


def test_an_edge_of_three_faces_is_refused():
    vertices = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, -1, 0], [0, 0, 1.0]])
    with pytest.raises(InputError, match="1 non-manifold edges"):
        sound_poses([shape(vertices, [[0, 1, 2], [1, 0, 3], [0, 1, 4]])], fill=True)
