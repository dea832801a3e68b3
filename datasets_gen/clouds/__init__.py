"""Point clouds and surfaces from files of any program of the field: understood, or refused with the line.

Read `point_cloud` (what a file holds), then `file_formats`, which knows the endings; each format has one
file: `ply_elements` and `ply_surfaces`, `obj_surfaces`, `off_surfaces`, `stl_surfaces`, `gltf_scenes`,
`text_tables` (rows of numbers) and `text_columns` (which column is what), `pcd_clouds`, `array_clouds`
(NumPy) and `las_clouds`. `cleaning` drops points that are no numbers and completes normals; `precision` tells
what rounding has left of the detail; `measures` and `mesh_measures` are what ``medialbench inspect`` prints.
"""
