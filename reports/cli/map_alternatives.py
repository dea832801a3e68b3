"""What ``medialbench match`` says and writes of maps that may be right instead of the chosen one."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports.cli.map_options import check_map_outputs, draw_map, write_map

LIKELY = 0.5
"""Probability below which a map without alternatives is said to be doubtful."""
ELSEWHERE = 0.05
"""Distance, relative to the diagonal of the box about the target, from which two places differ."""

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

    from medial import Matching
    from reports.cli.cloud_files import ThinnedCloud


def numbered(path: Path, number: int) -> Path:
    """The path with a number at the end of its name: ``a.map.npz`` -> ``a-2.map.npz``."""
    name, dot, suffixes = path.name.partition(".")
    return path.with_name(f"{name}-{number}{dot}{suffixes}")


def write_alternatives(
    out: Path,
    picture: Path | None,
    clouds: tuple["ThinnedCloud", "ThinnedCloud"],
    inputs: tuple[Path, Path],
    found: "Matching",
    about: dict[str, Any],
) -> list[Path]:
    """Write each alternative as a map of its own, and draw it if there is a picture.

    Parameters
    ----------
    out, picture
        Files of the chosen map; those of the alternatives are `numbered` from 2 on.
    clouds, inputs
        Source and target, and their files, which are not overwritten.
    found
        Of the matched points.
    about
        Of the chosen map.

    Returns
    -------
    list of Path
        Of the maps.
    """
    written = []
    for number, each in enumerate(found.as_alternatives(), start=2):
        path, drawn = numbered(out, number), numbered(picture, number) if picture else None
        names = (inputs[0].name, inputs[1].name)
        check_map_outputs(path, drawn, None, inputs)
        write_map(path, clouds, names, each, about | {"alternative_to": out.name})
        if drawn is not None:
            draw_map(drawn, clouds, names, each, f"alternative {number}")
        written.append(path)
    return written


def sent_elsewhere(
    first: "NDArray[np.int64]", second: "NDArray[np.int64]", target: "NDArray[np.float64]"
) -> float:
    """Share of the points that two maps send to places farther apart than `ELSEWHERE` of the target's extent.

    Parameters
    ----------
    first, second : (n,) int64
        Ids of target points; those below 0 in either do not count.
    target : (m, 3) float64
    """
    import numpy as np

    both = (first >= 0) & (second >= 0)
    if not both.any():
        return 0.0
    apart = np.linalg.norm(target[first[both]] - target[second[both]], axis=1)
    return float((apart > ELSEWHERE * np.linalg.norm(np.ptp(target, axis=0))).mean())


def said_of_alternatives(
    found: "Matching", target: "NDArray[np.float64]", written: list[Path], drawn: bool = False
) -> list[str]:
    """What is said of a map that may be wrong as a whole, one line each; nothing if it is likely to be right.

    Parameters
    ----------
    found
    target : (m, 3) float64
        The points that it maps to.
    written
        Maps of its alternatives; empty if they were not asked for.
    drawn
        Whether there is a picture of each beside it.
    """
    if not found.alternatives and not found.probability < LIKELY:
        return []
    lines = [f"It is open whether this map is the right one: its probability is {found.probability:.2f}"]
    for number, each in enumerate(found.alternatives):
        place = f"; written to {written[number]}" if written else ""
        share = sent_elsewhere(found.source_to_target, each.source_to_target, target)
        differs = f"by over {ELSEWHERE:.0%} of the target's size at {share:.0%} of the points"
        other = f"  another one {each.probability:.2f}, which differs {differs}"
        lines.append(f"{other}{place}{', with its picture' if drawn else ''}")
    rest = 1 - found.probability - sum(each.probability for each in found.alternatives)
    if rest >= 0.005:
        lines.append(f"  a less likely one, or none that was found: {rest:.2f}")
    if found.alternatives and not written:
        lines.append("  --alternatives writes the other ones")
    return lines
