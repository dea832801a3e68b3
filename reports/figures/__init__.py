"""One module per figure: a function from a results table (or clouds) to a Matplotlib figure."""

from reports.figures.style import save

__all__ = ["save"]
