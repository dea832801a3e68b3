"""Arrays of files against what their records need."""

from dataclasses import replace

import numpy as np
import pytest

from datasets_gen import Collection, InputError, Shape
from datasets_gen.record_arrays import check_ids, check_layout
from medial import Diffusion, Matching
from scanner_sim import Scan
from tests.fuzzing import seeds

LAYOUT = {"points": "float n 3", "ids": "int n"}


def test_what_fits_is_taken_and_lengths_are_told():
    arrays = {"points": np.zeros((4, 3)), "ids": np.arange(4), "other": np.array("x")}
    assert check_layout(arrays, LAYOUT, finite="points") == {"n": 4}


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"points": np.zeros((4, 2))}, "points has shape"),
        ({"points": np.zeros(4)}, "points has shape"),
        ({"points": np.zeros((4, 3, 1))}, "points has shape"),
        ({"points": np.array(3.0)}, "points has shape"),
        ({"points": np.zeros((4, 3), int)}, "not float"),
        ({"points": np.zeros((4, 3), ">f8")}, "not float"),
        ({"points": np.full((4, 3), np.nan)}, "NaN or infinite"),
        ({"ids": np.arange(5)}, "ids has shape"),
        ({"ids": np.arange(4.0)}, "not int"),
        ({"ids": np.arange(4).astype("u8")}, "not int"),
        ({"ids": np.array(list("abcd"))}, "not int"),
    ],
)
def test_what_does_not_fit_is_named(change, says):
    arrays = {"points": np.zeros((4, 3)), "ids": np.arange(4)} | change
    with pytest.raises(ValueError, match=says):
        check_layout(arrays, LAYOUT, finite="points")


def test_what_is_missing_is_named():
    with pytest.raises(ValueError, match="ids is missing"):
        check_layout({"points": np.zeros((4, 3))}, LAYOUT)


def test_ids_are_in_range():
    check_ids(np.array([-1, 4]), 5, "ids", -1)
    check_ids(np.array([], int), 0, "ids")
    with pytest.raises(ValueError, match="ids holds 5"):
        check_ids(np.array([-1, 5]), 5, "ids", -1)
    with pytest.raises(ValueError, match="ids holds -1"):
        check_ids(np.array([-1, 4]), 5, "ids")


def _longer(mirror):
    return np.append(mirror, 0)


@pytest.mark.parametrize(
    ("cls", "record", "says"),
    [
        (Scan, lambda: replace(seeds.cloud(), normals=seeds.cloud().normals[:, :2]), "normals"),
        (Scan, lambda: replace(seeds.cloud(), points=seeds.cloud().points * np.nan), "points"),
        (Scan, lambda: replace(seeds.cloud(), shape_name=3), "shape_name"),
        (Shape, lambda: replace(seeds.shape(), faces=seeds.shape().faces * 1.0), "faces"),
        (Collection, lambda: replace(seeds.collection(), mirror=np.full(42, 42)), "mirror"),
        (
            Collection,
            lambda: replace(seeds.collection(), mirror=_longer(seeds.collection().mirror)),
            "mirror",
        ),
        (Diffusion, lambda: replace(seeds.diffusion(), areas=np.ones(3)), "areas"),
        (Diffusion, lambda: replace(seeds.diffusion(), eigenvalues=np.array([0, np.nan])), "eigenvalues"),
        (Matching, lambda: replace(seeds.matching(), confidence=np.full(30, 1.5)), "confidence"),
        (Matching, lambda: replace(seeds.matching(), confidence=np.full(30, np.nan)), "confidence"),
        (Matching, lambda: replace(seeds.matching(), source_to_target=np.full(30, 30)), "a map holds 30"),
        (Matching, lambda: replace(seeds.matching(), landmarks=np.array([[30, 0]])), "landmarks"),
    ],
)
def test_records_that_do_not_fit_are_refused_when_read(cls, record, says, tmp_path):
    record().save(tmp_path / "file.npz")
    with pytest.raises(InputError, match=says) as caught:
        cls.load(tmp_path / "file.npz")
    assert str(tmp_path / "file.npz") in str(caught.value)
