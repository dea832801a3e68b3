import numpy as np
import pytest

from datasets_gen import InputError, load, names, provenance, write_collection
from datasets_gen.bodies import built_in
from datasets_gen.bodies.body_plan import BodyPlan, Detail
from datasets_gen.bodies.built_in import Recipe, load_body, outline_body
from datasets_gen.bodies.implicit_surface import Body, ellipsoid
from datasets_gen.bodies.skeleton import Skeleton, hinge
from datasets_gen.registry import SOURCES, Source, outline


def egg(seed):
    """A body that takes a fraction of a second."""
    bones = (
        hinge("low", None, (0, 0, 0), (0, 0.4, 0), (1, 0, 0)),
        hinge("high", "low", (0, 0.4, 0), (0, 0.8, 0), (1, 0, 0)),
    )
    surface = Body((ellipsoid("low high", (0, 0.5, 0), (0.3, 0.5, 0.2 + 0.05 * seed), blend=0.02),))
    detail = Detail("high", np.array([0, 1.0, 0]), 0.1, 0.05)
    return BodyPlan(
        "egg",
        Skeleton(bones),
        surface,
        (detail,),
        0.08,
        0.03,
        0.2,
        {"rest": {}, "bent": {"high": (30, 0, 0)}},
        True,
    )


@pytest.fixture
def built(tmp_path, monkeypatch):
    """The egg as a built-in body, and the list of seeds with which it was built."""
    monkeypatch.setenv("MEDIALBENCH_CACHE", str(tmp_path / "cache"))
    monkeypatch.setitem(built_in.BODIES, "egg", Recipe("an egg", egg))
    monkeypatch.setitem(SOURCES, "egg", Source("an egg", load_body, outline_body))
    seeds, build = [], built_in.build_subjects

    def counted(plan, *others):
        seeds.append(plan)
        return build(plan, *others)

    monkeypatch.setattr(built_in, "build_subjects", counted)
    return seeds


def test_built_in_names():
    assert set(names()) >= {"human", "human_asymmetric", "quadruped"}


@pytest.mark.parametrize(
    ("name", "hint"),
    [("hunan", "'human'"), ("quadrupet", "'quadruped'"), ("zzz", "built in: human"), ("", "no dataset")],
)
def test_unknown_names_get_the_nearest(name, hint):
    with pytest.raises(InputError, match=hint) as caught:
        load(name)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("options", "reason"),
    [
        ({"sed": 1}, "no option 'sed'; it has seed, poses, subjects, variation, mesh_noise"),
        ({"seed": -1}, "seed of 'human' is -1"),
        ({"seed": 1.5}, "seed of 'human' is 1.5"),
        ({"seed": True}, "seed of 'human' is True"),
        ({"poses": ["fly"]}, "no pose 'fly'"),
        ({"poses": "walk"}, "give a list"),
        ({"poses": 3}, "give a list"),
        ({"poses": [3]}, "no pose 3"),
        ({"poses": [["walk"]]}, "no pose"),
    ],
)
def test_wrong_options_are_told_before_anything_is_built(options, reason, built):
    with pytest.raises(InputError, match=reason):
        load("human", **options)
    assert built == []


@pytest.mark.parametrize("name", [None, 3, [], b"human"])
def test_names_are_texts_or_paths(name):
    for function in (load, outline):
        with pytest.raises(InputError, match="is no data set; give the path of a folder, or one of human"):
            function(name)


def test_built_once_and_then_read(built):
    first, second = load("egg"), load("egg", seed=0)
    assert len(built) == 1
    assert np.array_equal(first["bent"].vertices, second["bent"].vertices)
    assert np.array_equal(first.mirror, second.mirror)
    assert first.reference.pose == second.reference.pose == "rest"


def test_same_seed_same_body_without_a_cache(built, tmp_path):
    """And another seed is the body of that seed: here of another half axis, .2 + .05 seed."""
    first = load("egg", seed=2)
    for file in (tmp_path / "cache").iterdir():
        file.unlink()
    second = load("egg", seed=np.int64(2))
    assert len(built) == 2
    assert np.array_equal(first["bent"].vertices, second["bent"].vertices)
    for body, half_axis in ((first, 0.3), (load("egg", seed=3), 0.35)):
        assert np.ptp(body.reference.vertices[:, 2]) == pytest.approx(2 * half_axis, rel=0.02)


def test_bodies_of_other_seeds_have_their_own_names(built):
    assert {s.name for s in load("egg", seed=3).shapes} == {"egg-3/rest", "egg-3/bent"}
    assert load("egg", seed=3).subject == "egg-3"


def test_provenance_of_built_in_bodies_only():
    """And they say with which options, and whether they are held out."""
    found = provenance("human", seed=3, subjects=2, variation=0.2)
    assert found == {
        "licence": "MIT",
        "source": "procedural body 'human' of medialbench",
        "held_out": False,
        "seed": 3,
        "subjects": 2,
        "variation": 0.2,
    }
    assert provenance("bird")["held_out"]
    with pytest.raises(InputError, match="no option 'size'"):
        provenance("human", size=3)
    with pytest.raises(InputError, match="not built in"):
        provenance("folder")


def test_a_package_that_is_not_installed_is_told_with_what_to_type():
    def source(package, install=""):
        return Source("x", load_body, outline_body, package=package, install=install)

    assert source(None).missing == source("numpy").missing == ""
    assert source("no_such_package").missing == "pip install no_such_package"
    assert source("no_such_package", "pip install 'medialbench[x]'").missing == "pip install 'medialbench[x]'"


def test_works_where_no_cache_can_be_written(built, tmp_path):
    (tmp_path / "cache").write_text("")
    assert len(load("egg").shapes) == 2


def test_poses_are_selected_in_the_order_asked(built):
    found = load("egg", poses=["bent"])
    assert [s.pose for s in found.shapes] == ["bent"]
    assert found.reference.pose == "rest"


def test_an_existing_folder_of_a_built_in_name_does_not_hide_it(built, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "egg").mkdir()
    assert load("egg").subject == "egg"


def test_an_outline_is_what_loading_gives(tmp_path):
    body = load("human", poses=["sit", "rest"])
    found = outline("human", poses=["sit", "rest"])
    assert found == {"subject": "human", "poses": list(body.poses), "reference": body.reference.pose}
    assert outline("quadruped", seed=3)["subject"] == "quadruped-3"
    write_collection(body, tmp_path)
    for options in ({}, {"poses": ["sit"], "reference": "sit"}):
        folder = load(tmp_path, **options)
        expected = {"subject": "human", "poses": list(folder.poses), "reference": folder.reference.pose}
        assert outline(tmp_path, **options) == expected


@pytest.mark.parametrize(
    ("name", "options", "message"),
    [("humn", {}, "did you mean 'human'"), ("human", {"seed": -1}, "seed of 'human' is -1"),
     ("human", {"poses": ["fly"]}, "no pose 'fly'"), ("human", {"size": 1}, "no option 'size'")],
)  # fmt: skip
def test_an_outline_refuses_what_loading_refuses(name, options, message):
    for function in (outline, load):
        with pytest.raises(InputError, match=message):
            function(name, **options)
