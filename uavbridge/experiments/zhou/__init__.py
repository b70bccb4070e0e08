"""Zhou et al. 2023, "Multitarget search using swarm robots in an unknown 3D mountain"."""
