"""Errors of maps and of operators, against exact ground truth.

Read `correspondence` (errors of a map and their curve), `mirror_images` (the same against the mirror
image of the truth) and `diffusion_error` (Eq. 18). `geodesic` measures distances on the rest pose;
`unfolding` holds its kernels. Every formula here decides scores, and only scores: stored maps are scored
again after a change.
"""
