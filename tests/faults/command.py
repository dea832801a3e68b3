"""The command ``medialbench``, with the stages of `light_stages` here and in its workers.

``MEDIALBENCH_TEST_START=SECONDS`` is how long workers may take to start, and
``MEDIALBENCH_TEST_GRACE=SECONDS`` how long they may say nothing beyond the time limit.
"""

import os

import dask

from evaluation.experiment.tasks import STAGES
from evaluation.running import local_workers, worker_watch
from reports.cli.main import main
from tests.faults.light_stages import LIGHT

if __name__ == "__main__":
    STAGES.update(LIGHT)
    dask.config.set({"distributed.worker.preload": ["tests.faults.light_workers"]})
    local_workers.START_WITHIN = float(os.environ.get("MEDIALBENCH_TEST_START", local_workers.START_WITHIN))
    worker_watch.GRACE = float(os.environ.get("MEDIALBENCH_TEST_GRACE", worker_watch.GRACE))
    main()
