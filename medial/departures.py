"""What the code does differently from the paper's equations, each by name, to be switched off in one place.

``departures="none"`` is the paper as written. It is given once, where an operator is built
(`medial.Diffusion.from_points`, Eqs. 5-15); what works on the operator follows it: `medial.match` (Sec. 4),
`medial.intrinsic_symmetry` (Sec. 5.2) and `evaluation.diffusion_error` (Eq. 18). `docs/paper.md` lists every
equation as a readable function, and the reasons.
"""

from collections.abc import Mapping
from dataclasses import dataclass, fields, replace
from typing import Any, ClassVar

from datasets_gen.records import InputError
from datasets_gen.values import CheckedSettings


@dataclass(frozen=True, kw_only=True)
class Departures(CheckedSettings):
    """Departures from the paper: True (the default) does what the text says, False follows the equation.

    Sizes (how large the reference cloud is, the cut-off, ...) are settings of `medial.operator.Operator`.
    """

    density_weights: bool = True
    """Eq. 5: a point counts ``reference_points * a / A``, its share of the surface, rather than 1."""
    radius_cap: bool = True
    """Eq. 7: phi = 0 for candidate balls larger than the smallest PCA width of the cloud."""
    truncation: bool = True
    """Eqs. 2 and 7: similarities below `cutoff` are dropped, and Gaussian weights below 1e-3 or beyond the 64
    nearest points. False keeps all that a double holds (from 2e-308), which is most pairs of points."""
    nearest_join: bool = True
    """Eq. 10: the twelve nearest points join the hull of a point, whatever their medial centres."""
    area_calibration: bool = True
    """Eq. 10: dual areas are scaled so that their median ratio to the surface areas is 1."""
    adaptive_bandwidth: bool = True
    """Eqs. 2 and 15: the bandwidth h of alpha follows the local sampling, and every point keeps its eight
    nearest neighbours. False takes one h for all pairs, three times the mean area of a point."""
    diffusion_rates: bool = True
    """Eq. 15: Gaussian weights are multiplied by h_ref / h after normalisation."""
    area_normalised_kernels: bool = True
    """Eqs. 16-17: m_t of each cloud is multiplied by the cloud's own area."""
    eq18_area_factor: bool = True
    """Eq. 18: both m_t are multiplied by the area of the reference mesh."""
    mirrored_symmetry: bool = True
    """Sec. 5.2: a cloud is matched to its own mirror image rather than to itself."""

    kind: ClassVar[str] = "departure"

    def __post_init__(self) -> None:
        """Check that every field is a truth value."""
        self.check_types()

    @classmethod
    def none(cls) -> "Departures":
        """The paper as written."""
        return cls(**{each.name: False for each in fields(cls)})

    @classmethod
    def of(cls, value: "Departures | Mapping[str, Any] | str") -> "Departures":
        """Departures from what a caller or a configuration file gives.

        Parameters
        ----------
        value
            Departures as they are, ``"all"`` or ``"none"``, or truth values by name; the others stay True.

        Raises
        ------
        InputError
            If a name is unknown or a value is not true or false.
        """
        if isinstance(value, cls):
            return value
        if isinstance(value, str) and value in ("all", "none"):
            return cls() if value == "all" else cls.none()
        if not isinstance(value, Mapping):
            raise InputError(f"departures is {value!r}; give 'all', 'none' or true and false by name")
        return cls(**value)

    def as_written(self, *names: str) -> "Departures":
        """The same with some departures switched off; InputError if one is not known."""
        return replace(self, **dict.fromkeys(names, False))


ALL_DEPARTURES = Departures()
"""The default: every departure."""
