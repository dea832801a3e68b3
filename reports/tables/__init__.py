"""Tables of a run.

Read `columns` (what is shown, and how), `leaderboard` (means over maps), `statistics` (paired tests), then
`formats` (Markdown, LaTeX, CSV) and `terminal`. Heads and digits may be changed without harm; the means
and the tests are what a report says.
"""
