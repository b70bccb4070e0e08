"""Planners by digital pheromones: detection and revisit, and the whole scenario (Shao 2020)."""
