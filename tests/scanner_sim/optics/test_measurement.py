import numpy as np
import pytest

from scanner_sim import ScannerConfig
from scanner_sim.optics.verdict import Verdict, verdicts
from scanner_sim.scanner import Rig


def judged(shape, **settings):
    rig = Rig(shape, ScannerConfig(resolution=(60, 60), shading="flat", **settings))
    hits, measured = rig.view(0, seed=0)
    return verdicts(hits, measured.index, measured.verdict, rig.config)


@pytest.mark.parametrize(
    ("settings", "most"),
    [
        ({}, Verdict.ACCEPTED),
        ({"material": "black"}, Verdict.DARK),
        ({"exposure": 20.0}, Verdict.SATURATED),
        ({"distance": 400.0}, Verdict.OUT_OF_RANGE),
        ({"fit": "least_squares", "residual_threshold": 1e-9}, Verdict.POOR_FIT),
        ({"depth_threshold": 1e-9}, Verdict.POOR_FIT),
        ({"views": ((1, 0, 0.35),)}, Verdict.GRAZING),
    ],
)
def test_verdicts_name_the_reason(plate, settings, most):
    verdict = judged(plate, **{"views": ((0, 0, 1),), **settings})
    assert np.bincount(verdict, minlength=8).argmax() == most


def test_verdict_of_hidden_pixels_is_shadow(torus):
    assert (judged(torus, views=((1, 0, 0.3),)) == Verdict.SHADOW).any()
