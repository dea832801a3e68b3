"""Fig. 1 of the paper: landmarks and dense map of scans from opposed sides, coloured by the medial embedding.

The source is scanned from the front alone and the target from behind, so that hardly any surface is in both.
Each cloud is seen from where it was scanned, and from the other side, where one looks into it.
"""

from reports.figures.cloud_sheet import FAR, INNER, NEAR, UNMATCHED, cloud_sheet
from reports.figures.figure_request import FigureRequest, MadeFigure, TwoPoses
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
    scanned = TwoPoses.of(request, "human", POSES, THRESHOLD, VIEWS, POINTS)
    body, source, target = scanned.body, scanned.source, scanned.target
    pair = MatchedPair.of(request, body, source, target)
    note = (
        f"{source.shape.name} scanned from the front ({VIEWS[0]}), {target.shape.name} from behind "
        f"({VIEWS[1]}), threshold {scanned.threshold:g}, seed {request.seed}; source {source.note}, target "
        f"{target.note}. Colours: where the source's medial centres (Eq. 9) lie; the target has those that "
        f"the map sends to it. {ALONE} Geodesic {pair.error_words} (x 100 / √area); {pair.chance_words}."
    )
    own, arrived = pair.colours()
    row = [
        pair.panel(side, colors, turned + 180 * side, title=f"{role}, {each.shape.pose}", note=seen)
        for side, colors, role, each in ((0, own, "source", source), (1, arrived, "target", target))
        for turned, seen in ((0, "from its scanned side"), (180, "from the other side"))
    ]
    sheet = cloud_sheet([row], key=[NEAR, FAR, INNER, UNMATCHED], note=note)
    return MadeFigure(sheet.figure, pair.table(), scanned.settings | {"views": VIEWS})
