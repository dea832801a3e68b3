"""Fig. 1 of the paper: landmarks and dense map of scans from opposed sides, coloured by the medial embedding.

The source is scanned from the front alone and the target from behind, so that hardly any surface is in both.
Each cloud is seen from where it was scanned, and from the other side, where one looks into it.
"""

from reports.figures.cloud_sheet import FAR, INNER, NEAR, UNMATCHED, cloud_sheet
from reports.figures.figure_request import FigureRequest, MadeFigure, ScannedPose
from reports.figures.matched_pair import ALONE, MatchedPair
from reports.figures.style import styled

POSES = ("rest", "walk")
VIEWS = ("front:2", "back:2")
THRESHOLD = 0.3
POINTS = 3000


@styled
def opposed_scans(request: FigureRequest) -> MadeFigure:
    """Match two poses scanned from opposite sides.

    Parameters
    ----------
    request

    Raises
    ------
    InputError
        If the data set has fewer than two poses, or a scan sees too little.
    """
    body = request.body("human")
    shapes = request.shapes(body, POSES, 2)
    threshold, points = request.threshold(THRESHOLD), request.count(POINTS)
    source, target = (
        ScannedPose.of(request, shape, threshold, views, points)
        for shape, views in zip(shapes, VIEWS, strict=True)
    )
    pair = MatchedPair.of(request, body, source, target)
    note = (
        f"{shapes[0].name} scanned from the front ({VIEWS[0]}), {shapes[1].name} from behind ({VIEWS[1]}), "
        f"threshold {threshold:g}, seed {request.seed}; source {source.note}, target {target.note}. Colours: "
        "where the source's medial centres (Eq. 9) lie; the target has those that the map sends to it. "
        f"{ALONE} Geodesic {pair.error_words} (x 100 / √area)."
    )
    settings = {"poses": [s.name for s in shapes], "views": VIEWS, "threshold": threshold, "points": points}
    own, arrived = pair.colours()
    row = [
        pair.panel(side, colors, turned + 180 * side, title=f"{role}, {shapes[side].pose}", note=seen)
        for side, colors, role in ((0, own, "source"), (1, arrived, "target"))
        for turned, seen in ((0, "from its scanned side"), (180, "from the other side"))
    ]
    sheet = cloud_sheet([row], key=[NEAR, FAR, INNER, UNMATCHED], note=note)
    return MadeFigure(sheet.figure, pair.table(), settings | {"seed": request.seed})
