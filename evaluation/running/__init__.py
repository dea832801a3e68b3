"""Running a plan: tasks go to the workers of a Dask cluster, results go to the results folder.

Read `run` (one call from experiment to table), `task_queue` and `execute` (which task is next, and what a
failure blocks), `worker` (one task, with `attempts` and `process` around it), then `stages` (what each
stage computes). `cluster` starts or joins Dask (`local_workers` on this machine), `worker_watch` looks after
its workers; `preview` is the dry run; `progress` holds the callbacks; `environment` is what run.json says of
the machine.

Only `stages` decides results. The rest may change without harm to them: it decides where and when tasks
run.
"""
