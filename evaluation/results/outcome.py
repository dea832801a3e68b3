"""How a task ended."""

from dataclasses import dataclass, field

from evaluation.experiment.tasks import Task


@dataclass(frozen=True, slots=True)
class Outcome:
    """How a task ended.

    Attributes
    ----------
    task : Task
    ok : bool
        Whether its result is stored.
    reason : str
        One line; empty if ok.
    kind : str
        ``"error"``, ``"timeout"``, ``"crash"``, ``"blocked"`` (an input failed) or ``"unavailable"`` (a
        package is missing); empty if ok.
    seconds : float
        Of computing and storing.
    detail : str
        Traceback, if any.
    """

    task: Task
    ok: bool
    reason: str = ""
    kind: str = ""
    seconds: float = 0.0
    detail: str = field(default="", repr=False)
