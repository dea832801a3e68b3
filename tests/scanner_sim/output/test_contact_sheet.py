import numpy as np
import pytest
from PIL import Image

from datasets_gen import InputError
from scanner_sim import ScannerConfig, write_contact_sheet
from scanner_sim.optics.verdict import Verdict
from scanner_sim.output.pixel_profiles import profiles
from scanner_sim.output.sheet_view import accepted_shares, levels, scanned
from scanner_sim.scanner import Rig


def colours_of(path):
    """How many colours a picture has: a blank one with titles and frames has fewer than 100."""
    image = np.array(Image.open(path).convert("RGB"))
    return len(np.unique(image.reshape(-1, 3), axis=0))


def test_contact_sheet_is_a_picture_of_its_view(torus, tmp_path):
    config = ScannerConfig(views=3, resolution=(80, 80), noise=0.1)
    write_contact_sheet(torus, tmp_path / "sheet.png", config, view=1)
    image = np.array(Image.open(tmp_path / "sheet.png"))
    assert image.shape[0] > 600
    assert image.shape[1] > 900
    assert len(np.unique(image.reshape(-1, image.shape[2]), axis=0)) > 500
    with pytest.raises(InputError, match="no view 3"):
        write_contact_sheet(torus, tmp_path / "none.png", config, view=3)
    assert not (tmp_path / "none.png").exists()


def test_all_views_make_a_taller_picture(torus, tmp_path):
    config = ScannerConfig(views=6, resolution=(40, 40))
    write_contact_sheet(torus, tmp_path / "one.png", config, view=0)
    write_contact_sheet(torus, tmp_path / "all.png", config)
    one, every = (Image.open(tmp_path / name).size for name in ("one.png", "all.png"))
    assert every[0] == one[0]
    assert every[1] - one[1] == pytest.approx(2 * 3.1 * 100, abs=2)  # two more rows of images


@pytest.mark.parametrize(
    "more",
    [
        {"cameras": 2},
        pytest.param({"footprint": 3, "background": 40.0}, marks=pytest.mark.slow),
        pytest.param({"min_range": 500.0}, marks=pytest.mark.slow),
    ],
)
def test_other_rigs_have_sheets_too(more, torus, tmp_path):
    values = {"views": 1, "resolution": (40, 40), "distance": 110.0, "max_range": 600.0} | more
    write_contact_sheet(torus, tmp_path / "sheet.png", ScannerConfig(**values))
    assert colours_of(tmp_path / "sheet.png") > 200


def test_profilers_have_sheets_too(torus, tmp_path):
    config = ScannerConfig(
        views=1, resolution=(40, 40), motion="profiler", profile_step=5.0, stripe_width=6.0
    )
    write_contact_sheet(torus, tmp_path / "sheet.png", config)
    assert colours_of(tmp_path / "sheet.png") > 200


def test_profiles_are_the_samples_that_were_fitted(torus):
    """Noise-free, the samples of an accepted pixel lie on its fit, up to quantisation."""
    rig = Rig(torus, ScannerConfig(views=2, resolution=(80, 80), fit="least_squares"))
    views = [scanned(rig, number, 0) for number in range(2)]
    found = profiles(rig, views, [1], 0)
    present = {verdict for view in views for verdict in Verdict if (view.judged == verdict).any()}
    assert {profile.verdict for profile in found} == present - {Verdict.MISS}
    accepted = found[0]
    assert (accepted.verdict, accepted.view) == (Verdict.ACCEPTED, 1)
    peak, middle, width = accepted.fit
    model = peak * np.exp(-(((accepted.angle - middle) / width) ** 2))
    near = np.abs(accepted.angle - middle) < width
    assert near.sum() >= 3
    assert np.abs(model - accepted.value)[near].max() < 0.02


def test_shares_fall_with_the_threshold_as_the_peaks_do(torus):
    rig = Rig(torus, ScannerConfig(views=2, resolution=(60, 60)))
    views = [scanned(rig, number, 0) for number in range(2)]
    thresholds = levels(0.1)
    assert thresholds == [0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 0.95]
    assert levels(0.75) == [0.75, 0.8, 0.9, 0.95]
    shares = accepted_shares(views, thresholds)
    assert (np.diff(shares) <= 0).all()
    accepted = sum(int((view.judged == Verdict.ACCEPTED).sum()) for view in views)
    assert shares[0] == pytest.approx(accepted / sum(len(view.judged) for view in views))
