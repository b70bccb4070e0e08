"""Recordings played again: to monitors, and to the planners to see whether they decide the same."""
