"""Methods, protocols, metrics and sweeps."""

from evaluation.experiment.experiment import Experiment, presets
from evaluation.metrics.correspondence import correspondence_error
from evaluation.metrics.diffusion_error import diffusion_error
from evaluation.results.merging import merge_results
from evaluation.results.store import ResultsStore
from evaluation.running.run import preview, run

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
