"""What is to be run: an experiment's settings, and the plan of tasks and table rows that follows from them.

Read `config_sections` (the sections of the TOML file), `experiment` (the file as a whole), `presets`,
then `tasks` (what one task is and what its key covers), `plan`, `subject_plan` (tasks of one subject) and
`make_plan`. `toml_tables` reads and writes TOML. Nothing here computes a result.

Defaults of the sections and the seeds decide results; labels and the order of planning do not.
"""
