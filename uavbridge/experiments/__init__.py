"""Repeats of the papers' tables and figures, and the runner that spreads their runs."""
