"""Errors of maps and of operators, against exact ground truth.

Read `correspondence` (errors of a map, the least that any map can have, and their curve), `mirror_images`
(the same against the mirror image of the truth), `limbs` (which limb goes to which), `medial_errors`
(distances within the body) and `diffusion_error` (Eq. 18). `geodesic` measures distances on the rest pose;
`nearest_place` and `unfolding` hold its kernels. Every formula here decides scores, and only scores: stored
maps are scored again after a change.
"""
