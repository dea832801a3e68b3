"""Names that come with data, as parts of paths: encoded where they are written, confined where they are read.

A pose, a subject, a method or an experiment may be called anything, also ``../../x``. No such name becomes a
path but through `safe_name` or `inside`.
"""

import hashlib
import os
from contextlib import suppress
from pathlib import Path

from datasets_gen.records import InputError

ESCAPE = "="
"""Begins two hexadecimal digits: unlike ``%`` it means nothing to a shell, to LaTeX or in an address."""
PLAIN = frozenset("-_.+,@ ()" + ESCAPE) - {ESCAPE}
"""Characters beside letters and digits that stay."""
LONGEST = 120
"""Bytes of a name; file systems take 255, and suffixes and temporary names need some."""
DEVICES = frozenset(
    ["con", "prn", "aux", "nul", *(f"{name}{i}" for name in ("com", "lpt") for i in range(10))]
)
"""Names that Windows keeps for devices, whatever the suffix."""
HARMFUL = frozenset("\0\u061c\u200e\u200f\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069")
"""Not in names: NUL, which few readers of tables take, and what turns the direction of other words."""
NO_CHARACTERS = range(0xD800, 0xE000)
"""Surrogates: what Python makes of bytes of a file's name that are not UTF-8."""


def check_text(text: str, what: str) -> None:
    """Raise InputError if a name cannot be written into a table and read again.

    Parameters
    ----------
    text
    what
        What it is a name of, for the message.
    """
    for c in text:
        if c in HARMFUL or ord(c) in NO_CHARACTERS:
            why = " (no UTF-8)" if ord(c) in NO_CHARACTERS else ""
            raise InputError(f"the {what} {text!r} holds {c!r}{why}; rename it")


def safe_name(text: str) -> str:
    """A file name for a text, the same for the same text and another one for another.

    Letters, digits and a few other characters stay; the rest is written as ``=2F``. A long name is cut and
    ends in a hash.

    Parameters
    ----------
    text
        Any text, empty too.

    Returns
    -------
    str
        One part of a path on every system: no separator, not hidden, not ``..``, no name of a device.
    """
    kept = "".join(c if c.isalnum() or c in PLAIN else _escaped(c) for c in text)
    if kept[:1] in (".", "-", " ", "") or kept.partition(".")[0].lower() in DEVICES:
        kept = _escaped(kept[:1]) + kept[1:]
    if kept[-1] in ". ":
        kept = kept[:-1] + _escaped(kept[-1])
    if len(kept.encode()) <= LONGEST:
        return kept
    start = kept.encode()[: LONGEST - 17].decode(errors="ignore")
    return f"{start}{ESCAPE}{hashlib.sha256(text.encode('utf-8', 'surrogatepass')).hexdigest()[:16]}"


def _escaped(text: str) -> str:
    return "".join(f"{ESCAPE}{byte:02X}" for byte in text.encode("utf-8", "surrogatepass")) or ESCAPE


def inside(folder: str | os.PathLike[str], name: str, what: str = "file") -> Path:
    """The path of a name in a folder.

    Parameters
    ----------
    folder
    name
        Relative, and maybe with folders in it.
    what
        What the name is of, for the message.

    Returns
    -------
    Path
        `folder` / `name`; need not exist.

    Raises
    ------
    InputError
        If that lies outside the folder, also by a symbolic link, or is the folder itself.
    """
    root = Path(folder)
    path = root / name
    try:
        home, goal = root.resolve(), path.resolve()
        with suppress(FileNotFoundError, NotADirectoryError, PermissionError):
            path.lstat()
    except (OSError, ValueError, RuntimeError) as error:  # a zero byte, too long, links that run in a circle
        raise InputError(f"the {what} {name!r} of {str(folder)!r} is no path; rename it") from error
    if Path(name).is_absolute() or goal == home or not goal.is_relative_to(home):
        raise InputError(
            f"the {what} {name!r} lies outside {str(folder)!r}; give the name of a file in that folder"
        )
    return path


def distinct_names(texts: list[str], what: str) -> dict[str, str]:
    """Safe name of each text.

    Raises
    ------
    InputError
        If two differ only in case, which some file systems do not tell apart.
    """
    found = {text: safe_name(text) for text in texts}
    seen: dict[str, str] = {}
    for text, name in found.items():
        other = seen.setdefault(name.casefold(), text)
        if other != text:
            raise InputError(f"{what}s {other!r} and {text!r} would be one file on some systems; rename one")
    return found
