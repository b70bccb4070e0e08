"""Shortest paths of vehicles that fly forwards and turn no tighter than a radius.

Poses are x, y, psi (car) or x, y, z, psi (airplane): ENU metres, z up, psi in radians from
east, counter-clockwise.
"""

from planners.paths.dubins.airplane import AirplanePath, airplane, airplane_lengths
from planners.paths.dubins.car import CarPath, car_lengths, shortest_car

__all__ = [
    "AirplanePath",
    "CarPath",
    "airplane",
    "airplane_lengths",
    "car_lengths",
    "shortest_car",
]
