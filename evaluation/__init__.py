"""Experiments: which shapes are scanned and matched by what, run on any number of workers, and scored.

Data go one way: `experiment` (settings and the plan of tasks), `running` (tasks on workers), `results`
(the folder and its table). A running task calls `methods` (correspondence) and `metrics` (errors).
`protocols` holds the packaged experiments; `generation` makes training data on the same workers. Read the
folders in this order; each says what may be touched without harm to results.
"""

from evaluation.experiment.experiment import Experiment
from evaluation.experiment.presets import presets
from evaluation.metrics.correspondence import correspondence_error
from evaluation.metrics.diffusion_error import diffusion_error
from evaluation.results.merging import merge_results
from evaluation.results.store import ResultsStore
from evaluation.running.preview import Outlook, preview
from evaluation.running.run import run

__all__ = [
    "Experiment",
    "Outlook",
    "ResultsStore",
    "correspondence_error",
    "diffusion_error",
    "merge_results",
    "presets",
    "preview",
    "run",
]
