"""Faults of the system under a sweep: full disks, lost processes, wrong clocks; docs/faults.md has more.

Apart from the tests that mirror the packages, as each fault goes through all of them: from the command over
the workers and the results folder to the files of `datasets_gen`. The sweep is planned, run, stored and
merged by the program itself; only what its stages compute is replaced (`light_stages`), so that a sweep takes
a second and a fault can be injected at each of its steps.

Read `sweep` (how one runs, in this process or as a command, and what has to hold afterwards), then
`failing_calls` (calls of the file system that fail) and ``start/sitecustomize.py`` (faults of processes as
they start).
"""
