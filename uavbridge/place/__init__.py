"""Place agents: who keeps the pheromone maps, in the environment or as copies on the UAVs."""
