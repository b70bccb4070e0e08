"""Batched vehicle models: every array has one vehicle a row."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType

from sim_vehicles.dynamics.airframe import GRAVITY, BatteryParams, MultirotorParams
from sim_vehicles.dynamics.model import F64, Bools, MakeModel, Setpoints, States, VehicleModel
from sim_vehicles.dynamics.multirotor import Multirotor
from sim_vehicles.dynamics.perfect import PerfectTracking
from sim_vehicles.dynamics.wind import Wind, WindSpec

__all__ = [
    "F64",
    "GRAVITY",
    "MODELS",
    "BatteryParams",
    "Bools",
    "MakeModel",
    "Multirotor",
    "MultirotorParams",
    "PerfectTracking",
    "Setpoints",
    "States",
    "VehicleModel",
    "Wind",
    "WindSpec",
]

# of multirotors, by name
MODELS: Mapping[str, MakeModel] = MappingProxyType(
    {"multirotor": Multirotor, "perfect": PerfectTracking}
)
