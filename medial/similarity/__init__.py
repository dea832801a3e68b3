"""Medial similarity phi of all pairs of points (Eqs. 4-7).

Read `equations` first, then the fast form in the order in which it works: `candidate_ball` (the ball of two
points), `leaves` (points in kd-tree order, eight to a leaf), `critical_radius` (how large a nearly empty ball
can be, cell by cell), `candidate_pairs` (pairs that may pass), `emptiness` (their phi) and `similarity`,
which calls them. `every_pair` is the slow form for balls of any radius.

May be touched: sizes of tasks, cells and leaves change the time and the last digits of phi, nothing else.
`SMALLEST_TANGENCY` and the margins of the culling change what is found.
"""
