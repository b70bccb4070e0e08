"""The simulated world beyond the vehicles: targets, and the payload sensors that look at them."""
