"""Fixed-wing aircraft: an Aerosonde with six degrees of freedom, and its guidance model."""

from sim_vehicles.dynamics.plane.airframe import Pack, PlaneLimits, PlaneParams
from sim_vehicles.dynamics.plane.follow import Follower, Target
from sim_vehicles.dynamics.plane.guided import GuidedPlane
from sim_vehicles.dynamics.plane.sixdof import SixDof

__all__ = [
    "Follower",
    "GuidedPlane",
    "Pack",
    "PlaneLimits",
    "PlaneParams",
    "SixDof",
    "Target",
]
