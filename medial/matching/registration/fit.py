"""A fit of one cloud onto another, and what it is worth.

Where both scans could see a surface they must agree; where one of them could not, its absence says nothing.
"""

from dataclasses import dataclass

from medial.matching.registration.deformation_graph import Float, Int, Pose

SEEN_WORTH = 0.3
"""Worth of surface that meets, relative to the cost of surface that should have met and does not."""
STRAIN_COST = 600.0
"""Cost of the mean square strain (areas) in the score of a fit. Chosen with `SEEN_WORTH` on 5,100 fits of
24 pairs, four of them from opposite sides, where strain tells half a turn about the long axis from the right
map; more of it costs bodies that bend much."""
HELD_WORTH = 0.75
"""Worth of the share of the body that holds together in the score of a fit. Fitted with `STRAIN_COST`."""


@dataclass(frozen=True)
class Fit:
    """A pose of the source, and how well both surfaces meet in it.

    Attributes
    ----------
    pose : Pose
    moved : (n, 3) float64
        Source points in that pose.
    partner : (n,) int64
        Nearest target point, in position and normal.
    found : (n,) float64
        How well each source point found the target, in [0, 1].
    found_back : (m,) float64
        How well each target point found the source.
    missed : float
        Share of the source that the target should show and does not, plus the share of the target that the
        source should show, in [0, 2] (`visibility`).
    strain : float
        Mean square disagreement of neighbouring nodes, in units of the area.
    held : float
        Share of the body that holds together, in [0, 1]: the mean of `NodeGraph.held`.
    """

    pose: Pose
    moved: Float
    partner: Int
    found: Float
    found_back: Float
    missed: float
    strain: float
    held: float

    @property
    def score(self) -> float:
        """How far the surfaces agree and what holds together of the body, less what the strain costs."""
        return self.agreement + HELD_WORTH * self.held - STRAIN_COST * self.strain

    @property
    def agreement(self) -> float:
        """How far both surfaces agree where the other scan could have seen them, in [0, 2].

        Surface that meets is worth little beyond that nothing is missed. Where both scans show everything,
        this is `seen`.
        """
        return (SEEN_WORTH * self.seen + 2 - self.missed) / (1 + SEEN_WORTH)

    @property
    def seen(self) -> float:
        """Share of the source that found the target plus share of the target that found the source."""
        return float(self.found.mean() + self.found_back.mean())
