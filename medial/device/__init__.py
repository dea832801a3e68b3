"""The heavy loops on a GPU (CUDA), or for tests on LLVM, in Dr.Jit: off the reader's path.

Nothing here is needed to understand the operator. Nothing is imported unless a device is asked for, except
`backend`, which says which devices there are. `pair_similarity` is `medial.similarity` by brute force, with
`leaf_lists` and `sparse_pairs`; `chebyshev` is the filter of `medial.spectrum.filtered_lanczos`.

May be touched freely: results on the processor do not depend on it.
"""
