"""Pure decisions for UAV swarm search: grids, belief maps, flocking rules, planners.

numpy only: nothing here opens a socket, reads a clock or a file, logs, or
draws from global randomness. The same planner flies a thousand Monte Carlo
runs in one process and a live fleet, unchanged.
"""
