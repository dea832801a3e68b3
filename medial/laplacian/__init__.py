"""Laplacians on point clouds (Eqs. 8, 14, 15) and their baselines."""
