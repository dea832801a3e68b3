"""What the tests of figures share: a request without progress, and a look at what is written."""

import matplotlib.image
import numpy as np

from reports.figures.figure_request import FigureRequest
from reports.figures.paper_figures import make_figure, write_figure

POINTS = 300


def request(number, **chosen):
    return FigureRequest(number, **({"points": POINTS, "tell": lambda _: None} | chosen))


def make(number, **chosen):
    return make_figure(request(number, **chosen))


def looked_at(number, made, folder):
    """Write a figure; its PNG shows something, its PDF has text as text, its CSV its numbers and origin."""
    import pandas as pd

    pdf = png = table = None
    for path in write_figure(number, made, folder):
        pdf, png, table = (
            path if path.suffix == suffix else known
            for suffix, known in ((".pdf", pdf), (".png", png), (".csv", table))
        )
    image = matplotlib.image.imread(png)
    assert image.shape[1] > 400
    assert image[..., :3].std() > 0.02
    data = pdf.read_bytes()
    assert b"/FontFile2" in data  # TrueType fonts, so letters and no outlines
    assert b"/Type3" not in data
    read = pd.read_csv(table)
    assert len(read) == len(made.table)
    assert set(read["experiment"]) == {f"figure {number}"}
    assert read["config_hash"].astype(str).str.len().eq(16).all()
    return read


def places(table, panel):
    """Points of a cloud of a table, (n, 3)."""
    rows = table[table["panel"] == panel]
    return rows[["x", "y", "z"]].to_numpy(), rows


def same_kernel(diffusion, point, time):
    """m_t(x, x) by the kernel of Eq. 13."""
    one = np.array([point])
    return diffusion.kernel(time, one, one)[0, 0]
