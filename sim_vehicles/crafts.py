"""The vehicles there are: each kind under each make of autopilot."""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Final

from sim_vehicles import px4_parameters
from sim_vehicles.ardupilot.crafts import COPTER, PLANE, ROVER
from sim_vehicles.codec import mav
from sim_vehicles.craft import Craft
from sim_vehicles.driving import DRIVING, DrivenLegs
from sim_vehicles.dynamics import MODELS
from sim_vehicles.dynamics.plane import GuidedPlane, SixDof
from sim_vehicles.dynamics.rover import GroundRover
from sim_vehicles.flavour import PX4
from sim_vehicles.modes import MODES, Mode
from sim_vehicles.routines import ROUTINES
from sim_vehicles.winged import PX4 as PX4_WINGED
from sim_vehicles.winged import WINGED, WingedLegs, px4

PX4_MULTIROTOR: Final = Craft(
    kind="multirotor",
    autopilot="px4",
    mav_type=mav.MAV_TYPE_QUADROTOR,
    flavour=PX4,
    models=MODELS,
    modes=MODES,
    routines=ROUTINES,
    parameters=px4_parameters.TABLE,
)

PX4_ROVER: Final = Craft(
    kind="rover",
    autopilot="px4",
    mav_type=mav.MAV_TYPE_GROUND_ROVER,
    flavour=PX4,
    models={"rover": GroundRover},
    modes={mode: spec for mode, spec in MODES.items() if mode is not Mode.ALTITUDE},
    routines=DRIVING,
    parameters=px4_parameters.ROVER,
    derive=px4_parameters.rover,
    legs=DrivenLegs,
)

PX4_PLANE: Final = Craft(
    kind="plane",
    autopilot="px4",
    mav_type=mav.MAV_TYPE_FIXED_WING,
    flavour=PX4,
    models={"six-dof": SixDof, "guidance": GuidedPlane},
    modes=MODES,
    routines=WINGED,
    parameters=PX4_WINGED,
    derive=px4,
    legs=WingedLegs,
)

CRAFTS: Final[Mapping[tuple[str, str], Craft]] = MappingProxyType(
    {
        (craft.autopilot, craft.kind): craft
        for craft in (PX4_MULTIROTOR, PX4_ROVER, PX4_PLANE, COPTER, ROVER, PLANE)
    }
)
"""By autopilot ("px4", "ardupilot") and kind ("multirotor", "rover", "plane")."""

MODEL_NAMES: Final = tuple(dict.fromkeys(name for each in CRAFTS.values() for name in each.models))
KINDS: Final = tuple(dict.fromkeys(kind for _, kind in CRAFTS))
AUTOPILOTS: Final = tuple(dict.fromkeys(autopilot for autopilot, _ in CRAFTS))
