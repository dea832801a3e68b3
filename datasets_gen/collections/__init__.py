"""Collections from files, one module per source: `folder` reads and writes a folder of posed meshes.

A new source is a new module whose loader returns a `Collection`, named in `datasets_gen.registry`.
"""
