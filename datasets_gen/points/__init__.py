"""What every package needs of a bare point cloud.

`farthest` (farthest-point orders), `outside` (which side of a cloud is outside), `normals` (PCA, signs from
the scanner or a spanning tree), `missing_normals` (of the few points without one), `neighbours` (graphs of
nearest neighbours without gaps) and `strays` (points far from all others). All of them decide scans or maps
to the last bit.
"""
