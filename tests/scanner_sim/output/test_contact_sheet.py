import numpy as np
import pytest
from PIL import Image

from datasets_gen import InputError
from scanner_sim import ScannerConfig, write_contact_sheet


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
