"""ArduPilot's vehicles."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from math import radians
from typing import Final

import numpy as np

from sim_vehicles.ardupilot import parameters, plane, routines
from sim_vehicles.ardupilot.flavour import ArduPilot
from sim_vehicles.codec import mav
from sim_vehicles.craft import Craft
from sim_vehicles.driving import DrivenLegs
from sim_vehicles.dynamics import MODELS
from sim_vehicles.dynamics.plane import GuidedPlane, PlaneParams, SixDof
from sim_vehicles.dynamics.rover import GroundRover, RoverParams
from sim_vehicles.failsafe import Action
from sim_vehicles.flavour import States
from sim_vehicles.modes import Mode, ModeSpec
from sim_vehicles.winged import WingedLegs

_GUIDED: Final[int] = mav.MAV_MODE_FLAG_GUIDED_ENABLED
_STICKS: Final[int] = mav.MAV_MODE_FLAG_MANUAL_INPUT_ENABLED
_COPTER: Final[int] = _STICKS | mav.MAV_MODE_FLAG_STABILIZE_ENABLED
_STANDBY: Final = States(*[int(mav.MAV_STATE_STANDBY)] * 3)
_PACK_MAH: Final = 5200.0  # of the models' batteries
_LINK: Final = {1: 2, 2: 2, 3: 2, 4: 2, 5: 3, 6: 2, 7: 3}  # FS_GCS_ENABLE -> NAV_DLL_ACT
_FENCE: Final = {1: Action.RETURN, 2: Action.LAND, 3: Action.RETURN, 4: Action.HOLD}
_GF_ACTION: Final = {Action.HOLD: 2, Action.RETURN: 3, Action.LAND: 5}

COPTER_MODES: Final[Mapping[Mode, tuple[int, int]]] = {
    Mode.MANUAL: (0, _COPTER),
    Mode.ALTITUDE: (2, _COPTER),
    Mode.MISSION: (3, _COPTER | _GUIDED),
    Mode.OFFBOARD: (4, _COPTER | _GUIDED),
    Mode.HOLD: (5, _COPTER | _GUIDED),
    Mode.RETURN: (6, _COPTER | _GUIDED),
    Mode.LAND: (9, _COPTER),
    Mode.POSITION: (16, _COPTER | _GUIDED),
    Mode.BRAKE: (17, _COPTER | _GUIDED),
}
ROVER_MODES: Final[Mapping[Mode, tuple[int, int]]] = {
    Mode.MANUAL: (0, _STICKS),
    Mode.BRAKE: (4, 0),
    Mode.HOLD: (5, _GUIDED),
    Mode.MISSION: (10, _GUIDED),
    Mode.RETURN: (11, _GUIDED),
    Mode.OFFBOARD: (15, _GUIDED),
}
PLANE_MODES: Final[Mapping[Mode, tuple[int, int]]] = {
    Mode.MANUAL: (0, _COPTER),
    Mode.ALTITUDE: (5, _COPTER),
    Mode.POSITION: (7, _COPTER | _GUIDED),
    Mode.MISSION: (10, _COPTER | _GUIDED),
    Mode.RETURN: (11, _COPTER | _GUIDED),
    Mode.HOLD: (12, _COPTER | _GUIDED),
    Mode.TAKEOFF: (13, _COPTER | _GUIDED),
    Mode.OFFBOARD: (15, _COPTER | _GUIDED),
}
"""``custom_mode`` and ``base_mode`` flags; a rover's HOLD stops and its LOITER stays."""


def _bounded(value: float, low: float, high: float) -> float:
    return min(max(value, low), high)


def _net(
    get: Callable[[str], float],
    highest: str,
    link: tuple[str, str] = ("FS_GCS_ENABLE", "FS_GCS_TIMEOUT"),
) -> dict[str, float]:
    """Fences and failsafes."""
    on = get("FENCE_ENABLE") == 1
    kinds = int(get("FENCE_TYPE")) if on else 0
    action = _FENCE.get(int(get("FENCE_ACTION")))
    return {
        "GF_MAX_VER_DIST": max(get(highest), 0.0) if kinds & 1 and highest else 0.0,
        "GF_MAX_HOR_DIST": max(get("FENCE_RADIUS"), 0.0) if kinds & 2 else 0.0,
        "POLYGON_FENCES": float(kinds & 4 > 0),
        "GF_ACTION": 1.0 if action is None else _GF_ACTION[action],
        "NAV_DLL_ACT": float(_LINK.get(int(get(link[0])), 0)),
        "COM_DL_LOSS_T": _bounded(get(link[1]), 1.0, 300.0),
        "COM_FAIL_ACT_T": 0.0,
        "BAT_LOW_THR": _bounded(get("BATT_LOW_MAH") / _PACK_MAH, 0.0, 1.0),
        "BAT_CRIT_THR": _bounded(get("BATT_CRT_MAH") / _PACK_MAH, 0.0, 1.0),
        "BAT_EMERGEN_THR": 0.0,
        "COM_ARM_BAT_MIN": -1.0,
    }


def _copter(get: Callable[[str], float]) -> Mapping[str, float]:
    """What ArduCopter's parameters mean, in the names that autopilots go by."""
    speed = _bounded(get("WPNAV_SPEED") / 100.0, 0.1, 30.0)
    up = _bounded(get("WPNAV_SPEED_UP") / 100.0, 0.1, 15.0)
    down = _bounded(get("WPNAV_SPEED_DN") / 100.0, 0.1, 15.0)
    low = max(get("LAND_ALT_LOW") / 100.0, 0.0)
    return {
        **_net(get, "FENCE_ALT_MAX"),
        "MPC_XY_CRUISE": speed,
        "MPC_XY_VEL_MAX": speed,
        "MPC_Z_VEL_MAX_UP": up,
        "MPC_Z_V_AUTO_UP": up,
        "MPC_TKO_SPEED": up,
        "MPC_TKO_RAMP_T": 1.5,
        "MPC_Z_VEL_MAX_DN": down,
        "MPC_Z_V_AUTO_DN": down,
        "MPC_LAND_SPEED": _bounded(get("LAND_SPEED") / 100.0, 0.1, 15.0),
        "MPC_LAND_ALT1": low + 0.1,
        "MPC_LAND_ALT2": low,
        "MPC_ACC_HOR": _bounded(get("WPNAV_ACCEL") / 100.0, 0.1, 15.0),
        "MPC_YAW_MODE": 0.0 if get("WP_YAW_BEHAVIOR") else 1.0,
        "NAV_ACC_RAD": _bounded(get("WPNAV_RADIUS") / 100.0, 0.05, 200.0),
        "COM_SPOOLUP_TIME": 0.0,
    }


def _rover(get: Callable[[str], float]) -> Mapping[str, float]:
    """What ArduRover's parameters mean."""
    speed = _bounded(get("WP_SPEED"), 0.1, 30.0)
    return {
        **_net(get, ""),
        "MPC_XY_CRUISE": speed,
        "MPC_XY_VEL_MAX": speed,
        "MPC_ACC_HOR": _bounded(get("ATC_ACCEL_MAX"), 0.1, 15.0),
        "NAV_ACC_RAD": _bounded(get("WP_RADIUS"), 0.05, 200.0),
    }


def _plane(get: Callable[[str], float]) -> Mapping[str, float]:
    """What ArduPlane's parameters mean."""
    slowest = _bounded(get("AIRSPEED_MIN"), 8.0, 70.0)
    fastest = _bounded(get("AIRSPEED_MAX"), slowest, 75.0)
    cruise = _bounded(get("AIRSPEED_CRUISE"), slowest, fastest)
    up = _bounded(get("TECS_CLMB_MAX"), 0.5, 15.0)
    down = _bounded(get("TECS_SINK_MAX"), 0.5, 15.0)
    return {
        **_net(get, "FENCE_ALT_MAX", ("FS_GCS_ENABL", "FS_LONG_TIMEOUT")),
        "FW_AIRSPD_MIN": slowest,
        "FW_AIRSPD_TRIM": cruise,
        "FW_LND_AIRSPD": -1.0,
        "FW_LND_ANG": 5.0,
        "FW_LND_FLALT": _bounded(get("LAND_FLARE_ALT"), 0.0, 50.0),
        "MIS_LND_ABRT_ALT": 30.0,
        "MIS_TAKEOFF_ALT": max(get("TKOFF_ALT"), 0.0),
        "MPC_XY_CRUISE": cruise,
        "MPC_XY_VEL_MAX": fastest,
        "MPC_Z_V_AUTO_UP": up,
        "MPC_Z_V_AUTO_DN": down,
        "MPC_Z_VEL_MAX_UP": 2.0 * up,
        "MPC_Z_VEL_MAX_DN": down,
        "MPC_TKO_SPEED": 2.0 * up,  # a take-off climbs steeper
        "NAV_ACC_RAD": _bounded(get("WP_RADIUS"), 0.05, 200.0),
        "NAV_LOITER_RAD": _bounded(get("WP_LOITER_RAD"), -1e4, 1e4),
        "NAV_MC_ALT_RAD": 10.0,
        "LNDMC_TRIG_TIME": 2.0,
        "COM_SPOOLUP_TIME": 0.5,
    }


def _mode(name: str, *, place: bool = True, arm: bool = True) -> ModeSpec:
    return ModeSpec(name, needs_position=place, armable=arm)


class RoverLegs(DrivenLegs):
    """Armed is under way: nothing counts as a landing."""

    def touching(self, t_us: int) -> tuple[list[int], list[int]]:
        status = self._status
        off, down = status.landed & status.armed, ~status.landed & ~status.armed
        return np.flatnonzero(off).tolist(), np.flatnonzero(down).tolist()


COPTER: Final = Craft(
    kind="multirotor",
    autopilot="ardupilot",
    mav_type=mav.MAV_TYPE_QUADROTOR,
    flavour=ArduPilot(
        "ArduCopter",
        COPTER_MODES,
        64463,
        _STANDBY,
        "Frame: QUAD/PLUS",
    ),
    models=MODELS,
    modes={
        Mode.MANUAL: _mode("STABILIZE", place=False),
        Mode.ALTITUDE: _mode("ALT_HOLD", place=False),
        Mode.MISSION: _mode("AUTO"),
        Mode.OFFBOARD: _mode("GUIDED"),
        Mode.HOLD: _mode("LOITER"),
        Mode.RETURN: _mode("RTL", arm=False),
        Mode.LAND: _mode("LAND", place=False, arm=False),
        Mode.POSITION: _mode("POSHOLD"),
        Mode.BRAKE: _mode("BRAKE", arm=False),
    },
    routines=routines.COPTER,
    parameters=parameters.COPTER,
    derive=_copter,
    start_mode=Mode.MANUAL,
    ready_s=(38.0, 41.5),
)

ROVER: Final = Craft(
    kind="rover",
    autopilot="ardupilot",
    mav_type=mav.MAV_TYPE_GROUND_ROVER,
    flavour=ArduPilot(
        "ArduRover",
        ROVER_MODES,
        61903,
        States(*[int(mav.MAV_STATE_ACTIVE)] * 3),
    ),
    models={
        "rover": partial(
            GroundRover,
            params=RoverParams(speed_m_s=6.0, accel_m_s2=0.9, turn_rad_s=radians(45.0), stop_m=0.4),
        )
    },
    modes={
        Mode.MANUAL: _mode("MANUAL", place=False),
        Mode.BRAKE: _mode("HOLD", place=False),
        Mode.HOLD: _mode("LOITER"),
        Mode.MISSION: _mode("AUTO"),
        Mode.RETURN: _mode("RTL", arm=False),
        Mode.OFFBOARD: _mode("GUIDED"),
    },
    routines=routines.ROVER,
    parameters=parameters.ROVER,
    derive=_rover,
    legs=RoverLegs,
    start_mode=Mode.MANUAL,
    ready_s=(38.0, 41.5),
)

PLANE: Final = Craft(
    kind="plane",
    autopilot="ardupilot",
    mav_type=mav.MAV_TYPE_FIXED_WING,
    flavour=ArduPilot(
        "ArduPlane",
        PLANE_MODES,
        62287,
        _STANDBY,
        local_setpoints=False,
    ),
    models={
        "guidance": partial(GuidedPlane, params=PlaneParams(limits=plane.LIMITS)),
        "six-dof": partial(SixDof, params=PlaneParams(limits=plane.LIMITS)),
    },
    modes={
        Mode.MANUAL: _mode("MANUAL", place=False),
        Mode.ALTITUDE: _mode("FBWA", place=False),
        Mode.POSITION: _mode("CRUISE", place=False),
        Mode.MISSION: _mode("AUTO"),
        Mode.RETURN: _mode("RTL", arm=False),
        Mode.HOLD: _mode("LOITER"),
        Mode.TAKEOFF: _mode("TAKEOFF"),
        Mode.OFFBOARD: _mode("GUIDED"),
    },
    routines=plane.ROUTINES,
    parameters=parameters.PLANE,
    derive=_plane,
    hidden=plane.HIDDEN,
    legs=WingedLegs,
    start_mode=Mode.MANUAL,
    ready_s=(20.5, 23.5),
)
