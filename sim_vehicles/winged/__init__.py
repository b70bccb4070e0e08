"""What fixed-wing autopilots do otherwise than multirotors': they never stop."""

from sim_vehicles.winged.legs import WingedLegs
from sim_vehicles.winged.parameters import PX4, px4
from sim_vehicles.winged.routines import WINGED

__all__ = ["PX4", "WINGED", "WingedLegs", "px4"]
