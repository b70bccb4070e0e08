"""Batched vehicle models: every array has one vehicle a row."""
