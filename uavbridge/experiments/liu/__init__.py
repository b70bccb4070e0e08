"""Liu et al. 2022, "Emergent search of UAV swarm guided by the target probability map"."""
