"""Triangle meshes.

`files` (read and write; `bad_lines` says where a file in text is wrong) and `conversion` (anything a user
holds, as a `Shape`) come first, then `colours` (colours and textures of files), `geometry` (normals, areas,
winding number: arrays only), `remeshing` (for the built-in bodies) and `mirroring` (which vertex mirrors
which).

`files`, `colours` and `conversion` may be extended. `geometry` and `remeshing` decide bodies and scans to the
last bit.
"""
