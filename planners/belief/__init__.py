"""Belief maps: update from a sensor reading, merging between agents, scores."""
