"""Matrices assembled on a device are those of the processor to the bit."""

import numpy as np

from medial.sparse import symmetric
from tests.medial.devices import on_each, require

pytestmark = on_each


def test_equals_the_processors(device):
    jit = require(device)
    from medial.device.sparse_pairs import symmetric_on

    rng = np.random.default_rng(0)
    i, j = np.triu_indices(60, k=1)
    kept = rng.permutation(len(i))[:500]
    kept = kept[i[kept] != 7]
    i, j, values = i[kept], j[kept], rng.random(len(kept))
    there = symmetric_on(jit, jit.UInt32(i), jit.UInt32(j), jit.Float64(values), 61)
    here = symmetric(i, j, values, 61)
    for name in ("indptr", "indices", "data"):
        assert np.array_equal(getattr(there, name), getattr(here, name))
        assert getattr(there, name).dtype == getattr(here, name).dtype
        assert getattr(there, name).flags.writeable
    there.sum_duplicates()
    assert np.array_equal(there.indices, here.indices)
