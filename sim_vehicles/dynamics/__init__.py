"""Batched vehicle models: every array has one vehicle a row."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from types import MappingProxyType

from sim_vehicles.dynamics.airframe import GRAVITY, BatteryParams, MultirotorParams
from sim_vehicles.dynamics.model import F64, Bools, Setpoints, States, VehicleModel
from sim_vehicles.dynamics.multirotor import Multirotor
from sim_vehicles.dynamics.perfect import PerfectTracking
from sim_vehicles.dynamics.wind import Wind, WindSpec

__all__ = [
    "F64",
    "GRAVITY",
    "MODELS",
    "BatteryParams",
    "Bools",
    "Multirotor",
    "MultirotorParams",
    "PerfectTracking",
    "Setpoints",
    "States",
    "VehicleModel",
    "Wind",
    "WindSpec",
]

# name -> model of vehicles at position (n, 3) ENU m and yaw (n,) rad
MODELS: Mapping[str, Callable[[F64, F64], VehicleModel]] = MappingProxyType(
    {"multirotor": Multirotor, "perfect": PerfectTracking}
)
