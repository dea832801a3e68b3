"""How a task ended."""

from dataclasses import dataclass, field

from evaluation.experiment.tasks import Task

LONGEST_REASON = 500
"""Characters of a reason; the detail has more of it."""
LONGEST_DETAIL = 100_000
"""Characters of a detail, half of them from its start and half from its end."""


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a task ended.

    Attributes
    ----------
    task : Task
    ok : bool
        Whether its result is stored.
    reason : str
        One printable line of at most `LONGEST_REASON` characters, whatever is given; empty if ok.
    kind : str
        ``"error"``, ``"timeout"``, ``"crash"``, ``"blocked"`` (an input failed) or ``"unavailable"`` (a
        package is missing); empty if ok. A worker also says ``"again"``: to be tried once more, alone.
    seconds : float
        Of computing and storing.
    detail : str
        Traceback, if any; of at most `LONGEST_DETAIL` characters.
    warnings : tuple of (str, str)
        What this project's packages warned of meanwhile: logger and message.
    """

    task: Task
    ok: bool
    reason: str = ""
    kind: str = ""
    seconds: float = 0.0
    detail: str = field(default="", repr=False)
    warnings: tuple[tuple[str, str], ...] = ()

    def __post_init__(self) -> None:
        """Make the reason one line that every file and terminal takes, and cut the detail."""
        object.__setattr__(self, "reason", printable(self.reason))
        if len(self.detail) > LONGEST_DETAIL:
            half = (LONGEST_DETAIL - 60) // 2
            cut = f"\n... {len(self.detail) - 2 * half:,} characters left out ...\n"
            object.__setattr__(self, "detail", self.detail[:half] + cut + self.detail[-half:])


def printable(text: str) -> str:
    """Text in one line, without control characters and halves of characters, cut at `LONGEST_REASON`."""
    line = " ".join("".join(c if c.isprintable() else " " for c in text).split())
    return line if len(line) <= LONGEST_REASON else line[: LONGEST_REASON - 1] + "…"


def one_line(error: BaseException) -> str:
    """Type and message of any exception, in one line."""
    try:
        said = str(error)
    except BaseException:  # a method's own exception may even ask the interpreter to exit
        said = "(it cannot say why)"
    if isinstance(error, MemoryError):
        said = said or "out of memory; use fewer points or fewer workers"
    return printable(f"{type(error).__name__}: {said}" if said else type(error).__name__)
