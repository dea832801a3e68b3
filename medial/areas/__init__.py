"""Medial axis (Eq. 9), dual areas (Eq. 10), and the surface area that a point stands for.

Read `equations` first (Eq. 1 too), then `dual_area` with `hull_triangles`, its kernel, and `surface_cells`:
Voronoi cells in tangent planes, from which the density weights of Eq. 5 follow.

May be touched: sizes of tasks. All other constants change areas, and with them every map.
"""
