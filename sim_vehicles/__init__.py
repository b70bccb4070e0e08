"""Light simulated vehicles that speak MAVLink: ``python -m sim_vehicles --count 50``."""
