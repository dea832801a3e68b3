"""Tasks: the units that a run computes, stores, and finds again the next time."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from datasets_gen.fingerprints import code_fingerprint, digest

STAGES: Mapping[str, str] = {
    "shape": "evaluation.running.stages.load_shapes",
    "render": "evaluation.running.stages.render_views",
    "scan": "evaluation.running.stages.threshold_scan",
    "operator": "evaluation.running.stages.build_operator",
    "map": "evaluation.running.stages.match_pair",
    "score": "evaluation.running.stages.score",
}
"""Stages and their modules, in the order data flows: poses of a subject; everything the scanner sees of a
pose; the cloud that a threshold and a number of points make of it; its operator; a map; its scores."""


@dataclass(frozen=True, slots=True)
class Task:
    """One result to be computed.

    Attributes
    ----------
    key : str
        Names the result: a hash of everything it depends on, after a few readable words.
    stage : str
        One of `STAGES`.
    spec : Mapping
        Settings that JSON can hold.
    inputs : Mapping of str to str
        Keys of the results it needs, by role.
    label : str
        For people.
    """

    key: str
    stage: str
    spec: Mapping[str, Any]
    inputs: Mapping[str, str]
    label: str

    @classmethod
    def of(
        cls, stage: str, spec: Mapping[str, Any], inputs: Mapping[str, str], label: str, code: str = ""
    ) -> "Task":
        """A task with the key that belongs to it.

        The key is a hash of the stage, the settings, the keys of the inputs, the code that the stage reaches
        through imports, and the versions of the libraries that this code imports.

        Parameters
        ----------
        stage, spec, inputs, label
        code
            Fingerprint of code that the stage itself does not import, such as a method's.
        """
        identity = [stage, spec, inputs, code_fingerprint(STAGES[stage]), code]
        return cls(f"{_slug(label)}-{digest(identity)[:16]}", stage, dict(spec), dict(inputs), label)


def _slug(label: str) -> str:
    """The label in characters that every file system takes, at most 48 of them."""
    words = "".join(c if c.isalnum() or c in ".+" else "-" for c in label.lower())
    return "-".join(filter(None, words.split("-")))[:48].strip("-.")
