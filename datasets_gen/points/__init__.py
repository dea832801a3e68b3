"""Bare point clouds: farthest points, normals, neighbours."""
