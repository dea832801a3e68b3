"""Names that programs give to the columns of a cloud, and what each of them means here."""

import re

_WORDS = {
    "x": "x coordx xcoord xcoordinate coordinatex posx px pointsx points0",
    "y": "y coordy ycoord ycoordinate coordinatey posy py pointsy points1",
    "z": "z coordz zcoord zcoordinate coordinatez posz pz pointsz points2",
    "nx": "nx normalx xnormal normx normals0 normalsx",
    "ny": "ny normaly ynormal normy normals1 normalsy",
    "nz": "nz normalz znormal normz normals2 normalsz",
    "r": "r red rf",
    "g": "g green gf",
    "b": "b blue bf",
}
MEANING = {word: name for name, words in _WORDS.items() for word in words.split()}
"""By a name in small letters, without brackets, blanks and punctuation."""
POINT, NORMAL, COLOUR = ("x", "y", "z"), ("nx", "ny", "nz"), ("r", "g", "b")
UNUSED = "-"
"""Name of a column that is left out."""


def as_names(words: list[str]) -> list[str]:
    """What columns mean, as far as it is known here, else their own names; empty if these are no names.

    Parameters
    ----------
    words
        As in ``X``, ``normal_x``, ``y [m]``, ``"red"``.
    """
    if not words or not all(re.match(r"[A-Za-z_\"'-]", word) for word in words):
        return []
    if any(re.fullmatch(r"[-+]?(nan|inf|infinity)", word, re.IGNORECASE) for word in words):
        return []
    found = [_meaning(word) for word in words]
    return found if any(each in POINT for each in found) or len(found) > 2 else []


def _meaning(word: str) -> str:
    plain = re.sub(r"\[.*?\]|\(.*?\)|[\s_.\-:]", "", word.lower())
    return MEANING.get(plain, word)
