import numpy as np
import pytest

from datasets_gen import InputError
from scanner_sim import ScannerConfig, estimated_normals, sample, scan


@pytest.mark.parametrize("kind", ["pca", "mst"])
def test_scans_with_estimated_normals(sphere, kind):
    found = scan(sphere, ScannerConfig(views=8, resolution=(120, 120), normals=kind))
    outward = found.true_points / 37.5
    cosine = np.einsum("nd,nd->n", found.normals, outward)
    assert (cosine > 0).mean() > 0.999
    assert np.degrees(np.arccos(np.clip(cosine, -1, 1))).mean() < 2.0


def test_estimation_on_a_thinned_scan(sphere):
    found = scan(sphere, ScannerConfig(views=8, resolution=(120, 120))).accept(0.4).subsample(4000)
    for kind in ("pca", "mst"):
        cosine = np.einsum("nd,nd->n", estimated_normals(found, kind), found.true_points / 37.5)
        assert (cosine > 0.9).mean() > 0.99
    with pytest.raises(InputError, match="viewpoints"):
        estimated_normals(sample(sphere, 500), "pca")
    with pytest.raises(InputError, match="'pcb'"):
        estimated_normals(found, "pcb")
