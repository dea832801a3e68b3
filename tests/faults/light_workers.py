"""Loaded by Dask's workers as they start: the stages are those of `light_stages`."""

from evaluation.experiment.tasks import STAGES
from tests.faults.light_stages import LIGHT

STAGES.update(LIGHT)
