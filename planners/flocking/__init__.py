"""Flocking rules as batched kernels: what neighbours make an agent want."""
