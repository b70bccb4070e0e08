"""Paths over a grid, as pure geometry."""
