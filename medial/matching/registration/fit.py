"""A fit of one cloud onto another, and what it is worth.

Where both scans could see a surface they must agree; where one of them could not, its absence says nothing.
"""

from dataclasses import dataclass

from medial.matching.registration.deformation_graph import Float, Int, Pose
from medial.matching.registration.evidence import Weights


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
    weights : Weights
        What the score is made with.
    """

    pose: Pose
    moved: Float
    partner: Int
    found: Float
    found_back: Float
    missed: float
    strain: float
    held: float
    weights: Weights

    @property
    def score(self) -> float:
        """How far the surfaces agree and what holds together of the body, less what the strain costs."""
        return self.agreement + self.weights.held * self.held - self.weights.strain * self.strain

    @property
    def agreement(self) -> float:
        """How far both surfaces agree where the other scan could have seen them, in [0, 2].

        Surface that meets is worth little beyond that nothing is missed. Where both scans show everything,
        this is `seen`.
        """
        return (self.weights.seen * self.seen + 2 - self.missed) / (1 + self.weights.seen)

    @property
    def seen(self) -> float:
        """Share of the source that found the target plus share of the target that found the source."""
        return float(self.found.mean() + self.found_back.mean())
