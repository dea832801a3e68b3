import logging
from dataclasses import replace

import numpy as np
import pytest

from datasets_gen import Collection, cache
from tests.datasets_gen.collections.test_folder import posed


@pytest.fixture(autouse=True)
def own_cache(tmp_path, monkeypatch):
    monkeypatch.setenv("MEDIALBENCH_CACHE", str(tmp_path / "cache"))


def ball(mirror=None):
    shapes = (posed("pose2"), posed("rest"))
    return Collection("ball", shapes, shapes[1], mirror)


def path_of(name, seed, module="datasets_gen.bodies.human"):
    return cache.cache_path(name, {"seed": seed}, module)


@pytest.mark.parametrize("mirror", [None, np.arange(162)])
def test_collection_survives_exactly(mirror):
    path = path_of("ball", 1)
    assert cache.fetch(path) is None
    cache.store(path, ball(mirror))
    found = cache.fetch(path)
    assert [s.name for s in found.shapes] == ["ball/pose2", "ball/rest"]
    assert found.reference is found.shapes[1]
    assert np.array_equal(found.reference.vertices, posed("rest").vertices)
    assert np.array_equal(found.reference.faces, posed("rest").faces)
    assert (found.mirror is None) == (mirror is None)
    assert found.reference.units == "m"


def test_key_changes_with_name_parameters_and_code(monkeypatch):
    paths = {
        path_of("a", 1),
        path_of("b", 1),
        path_of("a", 2),
        path_of("a", 1, "datasets_gen.bodies.quadruped"),
    }
    monkeypatch.setattr(cache, "code_fingerprint", lambda *modules: "other")
    paths.add(path_of("a", 1))
    assert len(paths) == 5
    assert path_of("a", 1) in paths


def test_folder_is_the_environments_or_the_users(monkeypatch, tmp_path):
    assert cache.cache_folder() == tmp_path / "cache"
    monkeypatch.delenv("MEDIALBENCH_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache.cache_folder() == tmp_path / "xdg" / "medialbench"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert cache.cache_folder() == tmp_path / "home" / ".cache" / "medialbench"


@pytest.mark.parametrize("damage", [b"", b"garbage", None])
def test_damaged_file_is_not_used(damage, caplog):
    path = path_of("ball", 0)
    cache.store(path, ball())
    path.write_bytes(path.read_bytes()[:500] if damage is None else damage)
    with caplog.at_level(logging.WARNING):
        assert cache.fetch(path) is None
    assert "building it again" in caplog.text


def test_folder_that_cannot_be_written_is_logged_only(tmp_path, caplog):
    (tmp_path / "cache").write_text("a file where the folder should be")
    with caplog.at_level(logging.WARNING):
        cache.store(path_of("ball", 0), ball())
    assert "without a cache" in caplog.text


def test_nothing_temporary_is_left(tmp_path):
    cache.store(path_of("ball", 0), ball())
    assert len(list((tmp_path / "cache").iterdir())) == 1


def test_a_name_is_no_way_out_of_the_cache(tmp_path):
    path = path_of("../../../esc", 0)
    assert path.resolve().parent == (tmp_path / "cache").resolve()


@pytest.mark.parametrize("kind", ["cut", "garbled", "flipped", "empty"])
def test_a_damaged_body_is_built_again_and_replaced(kind, monkeypatch, caplog):
    from datasets_gen import registry
    from datasets_gen.bodies import built_in

    built = []

    def build(plan, *others):
        built.append(plan)
        poses = registry.outline("human")["poses"]
        shapes = tuple(replace(posed("rest"), name=f"ball/{pose}", pose=pose) for pose in poses)
        return Collection("ball", shapes, shapes[0])

    monkeypatch.setattr(built_in, "build_subjects", build)
    expected = registry.load("human")
    (path,) = cache.cache_folder().glob("human-*.npz")
    whole = path.read_bytes()
    middle = len(whole) // 2
    flipped = whole[:middle] + bytes([whole[middle] ^ 4]) + whole[middle + 1 :]
    path.write_bytes({"cut": whole[:middle], "garbled": whole[::-1], "flipped": flipped, "empty": b""}[kind])
    with caplog.at_level(logging.WARNING):
        found = registry.load("human")
    assert len(built) == 2
    assert str(path) in caplog.text
    assert np.array_equal(found.reference.vertices, expected.reference.vertices)
    assert registry.load("human").poses == expected.poses
    assert len(built) == 2  # the file is whole again
