"""The packaged experiments, one TOML file each; `evaluation.experiment.presets` reads them.

Every setting in these files decides results, except ``name``, ``description`` and ``timeout``.
"""
