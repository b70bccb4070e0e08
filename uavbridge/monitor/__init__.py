"""Watching a mission while it flies."""
