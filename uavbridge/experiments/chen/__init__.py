"""Chen et al. 2023: starling flocks of fixed-wing aircraft."""
