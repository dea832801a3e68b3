"""Triangle meshes: files, remeshing, and the mirror map of a mesh."""
