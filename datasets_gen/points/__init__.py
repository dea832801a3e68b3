"""What every package needs of a bare point cloud.

`farthest` (farthest-point orders), `normals` (PCA, signs from the scanner or a spanning tree) and
`neighbours` (graphs of nearest neighbours without gaps). All of them decide scans or maps to the last bit.
"""
