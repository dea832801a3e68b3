"""Methods, protocols, metrics and sweeps."""

from evaluation.experiment import Experiment, presets
from evaluation.merging import merge_results
from evaluation.metrics import correspondence_error
from evaluation.runs import preview, run
from evaluation.stability import diffusion_error
from evaluation.store import ResultsStore

__all__ = [
    "Experiment",
    "ResultsStore",
    "correspondence_error",
    "diffusion_error",
    "merge_results",
    "presets",
    "preview",
    "run",
]
