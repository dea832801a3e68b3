"""What ``medialbench match`` says and writes of maps that may be right instead of the chosen one."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from reports.cli.map_options import check_map_outputs, draw_map, write_map

if TYPE_CHECKING:
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
        check_map_outputs(path, drawn, inputs)
        write_map(path, *clouds, each, about | {"alternative_to": out.name})
        if drawn is not None:
            draw_map(drawn, clouds, (inputs[0].name, inputs[1].name), each)
        written.append(path)
    return written


def said_of_alternatives(found: "Matching", written: list[Path]) -> list[str]:
    """One line for each alternative; nothing if there is none."""
    if not found.alternatives:
        return []
    lines = [
        f"The clouds leave open which map is right: this one has a probability of {found.probability:.2f}"
    ]
    for number, each in enumerate(found.alternatives):
        place = f"written to {written[number]}" if written else "--alternatives writes it"
        lines.append(f"  another one {each.probability:.2f}; {place}")
    return lines
