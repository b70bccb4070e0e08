"""A MAVLink-connected mission bridge for UAV swarm search."""
