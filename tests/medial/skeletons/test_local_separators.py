"""The peer from another package, and what is said without it."""

import numpy as np
import pytest

from datasets_gen.records import InputError
from medial.skeletons import SKELETON_METHODS, skeleton_of
from medial.skeletons import local_separators as home
from tests.medial.skeletons import tubes


def test_a_missing_package_is_named_with_the_command(monkeypatch):
    monkeypatch.setattr(home, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=r"needs pygel3d: pip install .*skeletons"):
        skeleton_of(*np.zeros((2, 50, 3)), "local-separators")


def test_an_unknown_method_is_named():
    with pytest.raises(InputError, match="unknown skeleton method 'rosy'; did you mean 'rosa'"):
        skeleton_of(*np.zeros((2, 50, 3)), "rosy")
    assert list(SKELETON_METHODS) == ["rosa", "medial", "local-separators"]


def test_a_tube(capfd):
    pytest.importorskip("pygel3d")
    tube = tubes.bent(900)
    found = skeleton_of(tube.points, tube.normals, "local-separators")
    assert (found.kinds == "tip").sum() == 2
    away = np.linalg.norm(found.nodes[:, None] - tube.line[None, ::20], axis=2).min(axis=1)
    assert np.median(away) < 0.2 * tubes.RADIUS
    assert capfd.readouterr().out == ""
