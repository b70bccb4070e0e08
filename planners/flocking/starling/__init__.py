"""Starling flocks of fixed-wing aircraft (Chen et al. 2023) as batched kernels."""
