"""Laplacians on point clouds: of medial similarity (Eqs. 2-3, 8, 14-15), and two baselines.

Read `equations` first, then `weights`, the same with sparse matrices. `heat` is the Gaussian operator [BSW09]
alone, `tufted` the Laplacian of Sharp & Crane.

May be touched: nothing without a change of results.
"""
