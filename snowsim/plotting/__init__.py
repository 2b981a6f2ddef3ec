"""Figures: every plot_* draws one table on the axes it is given; only this package imports matplotlib."""

from snowsim.plotting.style import new_figure, note_source

__all__ = ["new_figure", "note_source"]
