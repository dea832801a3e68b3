"""The smallest modes of an operator, and the times at which they are compared (Eqs. 11-13).

Read `equations` first, then `modes`, which chooses the solver: a dense one for small clouds,
`filtered_lanczos` for the medial and heat operators, `shift_invert` for the tufted one; both use `krylov`.
`times` holds the logarithmic times of Sec. 4 and Eq. 18.

May be touched: the solvers' constants, as long as residuals stay below the tolerance; last digits change.
"""
