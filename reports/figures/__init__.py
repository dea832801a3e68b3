"""One file per figure, named after what it shows: a function from a table or clouds to a Matplotlib figure.

Read `style` (fonts, colours, saving), then `point_renderer` and `cloud_drawing` (pictures of clouds inside
figures), then any figure; `pair_pictures` turns stored maps into what `method_comparison` draws. All of it
may be changed without harm to results.
"""

from reports.figures.style import save

__all__ = ["save"]
