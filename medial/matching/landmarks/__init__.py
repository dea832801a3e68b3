"""Where maps start: landmarks with partners, and the maps that are extrapolated from them (Sec. 4).

Read in the order of the paper: `samples` (S_P and S_Q), `descriptors` (m_t and signatures),
`diffusion_landmarks` (Eq. 16), `extrapolation` (Eq. 17), with `equations` as the readable reference of both.
Then what the paper does not have: `medial_paths` (lengths along the body), `path_landmarks` (landmarks that
agree in them), `rigid_starts` (principal axes), and `candidates`, which makes a map of each landmark set.
Everything here changes maps; blocks and loops in `diffusion_landmarks` change only the time it takes.
"""
