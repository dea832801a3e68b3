"""Command line ``medialbench``: one file per command.

Read `main` (the group), then a command. `console` and `progress` decide what is printed, `cloud_files` reads
clouds (formats are in `datasets_gen.clouds`), `output_paths` checks where results go, `map_options` holds
what match and symmetry share, `set_options` and `setting_list` what --set takes. Messages, options and
defaults of outputs may change without harm to results; the thinning of clouds in `cloud_files` may not.
"""
