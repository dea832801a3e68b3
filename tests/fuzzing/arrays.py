"""Broken ``.npz`` and ``.parquet`` files whose checksums hold, so that the reader behind them is reached."""

import io
import zipfile
from random import Random

import numpy as np

from tests.fuzzing.mutations import mutated

VALUES = (np.nan, np.inf, -np.inf, 1e308, -1e308, 1e-320, -1, 0, 2**31 - 1, 2**31, 2**62, 0.5)
TYPES = ("f4", "f2", "i1", "u8", "i8", "f8", "c16", "?", "U3", "S2", "M8[s]", ">f8")


def mutated_npz(rng: Random, data: bytes, tokens=()) -> bytes:
    """An ``.npz`` with one or two members changed, or broken as bytes in one of eight."""
    if rng.random() < 0.125:
        return mutated(rng, data, tokens)
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as found:
            members = {name: found.read(name) for name in found.namelist()}
    except Exception:  # already broken
        return mutated(rng, data, tokens)
    for _ in range(rng.choice((1, 1, 2))):
        _change(rng, members, tokens)
    out = io.BytesIO()
    with zipfile.ZipFile(out, "w") as made:
        for name, content in members.items():
            made.writestr(name, content)
    return out.getvalue()


def _change(rng, members, tokens):
    if not members:
        return
    name = rng.choice(list(members))
    kind = rng.randrange(8)
    if kind == 0:
        del members[name]
    elif kind == 1:
        members[rng.choice(list(members))] = members[name]
    elif kind == 2:  # the header tells of another size or type
        members[name] = mutated(rng, members[name][:128], tokens) + members[name][128:]
    else:
        try:
            array = np.load(io.BytesIO(members[name]), allow_pickle=False)
            members[name] = _npy(
                _other_text(rng, array, tokens) if name == "meta.npy" else _another(rng, array)
            )
        except Exception:  # some changes do not suit some types
            members[name] = members[name][: rng.randrange(len(members[name]) + 1)]


def _other_text(rng, array, tokens):
    return np.array(mutated(rng, str(array).encode(), tokens).decode("utf-8", "replace"))


def _another(rng, array):
    kind = rng.randrange(8)
    if kind <= 2 and array.size:
        wide = array.astype(np.float64 if rng.random() < 0.3 else array.dtype).copy()
        with np.errstate(all="ignore"):
            value = np.array(rng.choice(VALUES)).astype(wide.dtype)
        rows = rng.choice((rng.randrange(wide.size), slice(None), slice(0, max(1, wide.size // 2))))
        wide.ravel()[rows] = value
        return wide
    if kind == 3:
        with np.errstate(all="ignore"):
            return array.astype(rng.choice(TYPES))
    if kind == 4:
        return array[: rng.randrange(len(array) + 1)]
    if kind == 5:
        return rng.choice(
            (array.ravel(), array[..., None], array.T, array[None], np.zeros((0, *array.shape[1:])))
        )
    if kind == 6:
        return np.concatenate([array, array[: rng.randrange(1, 5)]])
    return rng.choice(
        (np.array(3), np.zeros((0,)), np.zeros((2, 2)), np.array("text"), array[..., : rng.randrange(3)])
    )


def _npy(array):
    out = io.BytesIO()
    np.save(out, array, allow_pickle=False)
    return out.getvalue()


def mutated_parquet(rng: Random, data: bytes, tokens=()) -> bytes:
    """A table with a column changed, or broken as bytes in half of the cases."""
    if rng.random() < 0.5:
        return mutated(rng, data, tokens)
    import pandas as pd

    try:
        table = pd.read_parquet(io.BytesIO(data))
        name = rng.choice(list(table.columns))
        kind = rng.randrange(5)
        if kind == 0:
            table = table.drop(columns=name)
        elif kind == 1:
            table = table.rename(columns={name: rng.choice(("", "other", "dataset", "kind"))})
        elif kind == 2:
            table[name] = rng.choice((np.nan, "text", -1, 1e308, True, None))
        elif kind == 3:
            table = table.head(rng.randrange(3))
        else:
            table = table.assign(**{str(name): list(range(len(table)))})
        out = io.BytesIO()
        table.to_parquet(out)
        return out.getvalue()
    except Exception:  # already broken, or two columns of one name
        return mutated(rng, data, tokens)
