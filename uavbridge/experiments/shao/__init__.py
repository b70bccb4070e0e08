"""Shao et al. 2020: detection by digital pheromones, navigation by leader and followers."""
