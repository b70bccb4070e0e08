"""PX4's parameters that this autopilot acts on or that clients ask for, with PX4's defaults.

Values are those of a PX4 1.17 quadrotor. Ranges are what the autopilot can fly with.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from sim_vehicles.params import Parameter, Type


def whole(name: str, default: int, low: int = -(2**31), high: int = 2**31 - 1) -> Parameter:
    """A whole number."""
    return Parameter(name, Type.INT32, default, low, high)


def real(name: str, default: float, low: float = -1e6, high: float = 1e6) -> Parameter:
    """A number of single precision."""
    return Parameter(name, Type.REAL32, default, low, high)


TABLE: Final[tuple[Parameter, ...]] = (
    # power
    real("BAT1_CAPACITY", -1.0),
    whole("BAT1_N_CELLS", 4, 0, 16),
    whole("BAT1_SOURCE", 0),
    real("BAT1_V_CHARGED", 4.05),
    real("BAT1_V_EMPTY", 3.6),
    real("BAT_CRIT_THR", 0.07, 0.0, 1.0),
    real("BAT_EMERGEN_THR", 0.05, 0.0, 1.0),
    real("BAT_LOW_THR", 0.15, 0.0, 1.0),
    # circuit breakers
    whole("CBRK_FLIGHTTERM", 121212),
    whole("CBRK_IO_SAFETY", 22027),
    whole("CBRK_SUPPLY_CHK", 0),
    whole("CBRK_USB_CHK", 197848),
    # arming, disarming, failsafes
    whole("COM_ARMABLE", 1, 0, 1),
    real("COM_ARM_BAT_MIN", -1.0, -1.0, 0.9),
    whole("COM_ARM_MIS_REQ", 0, 0, 1),
    whole("COM_ARM_WO_GPS", 1, 0, 2),
    real("COM_DISARM_LAND", 2.0, -1.0, 1e4),
    real("COM_DISARM_PRFLT", 10.0, -1.0, 1e4),
    whole("COM_DL_LOSS_T", 10, 1, 300),
    real("COM_FAIL_ACT_T", 5.0, 0.0, 25.0),
    whole("COM_FLIGHT_UUID", 0),
    whole("COM_LOW_BAT_ACT", 3, 0, 3),
    whole("COM_OBL_RC_ACT", 0, 0, 7),
    real("COM_OF_LOSS_T", 1.0, 0.0, 60.0),
    whole("COM_RCL_EXCEPT", 0),
    whole("COM_RC_IN_MODE", 1),
    real("COM_RC_LOSS_T", 0.5),
    real("COM_SPOOLUP_TIME", 1.0, 0.0, 30.0),
    whole("COM_TAKEOFF_ACT", 0, 0, 1),
    # geofence
    whole("GF_ACTION", 2, 0, 5),
    real("GF_MAX_HOR_DIST", 0.0, 0.0, 1e5),
    real("GF_MAX_VER_DIST", 0.0, 0.0, 1e5),
    whole("GF_PREDICT", 0, 0, 1),
    whole("GF_SOURCE", 0, 0, 1),
    # land detector
    real("LNDMC_TRIG_TIME", 1.0, 0.1, 10.0),
    # identity
    whole("MAV_COMP_ID", 1, 1, 250),
    whole("MAV_PROTO_VER", 2, 0, 2),
    whole("MAV_SYS_ID", 1, 1, 255),
    whole("MAV_TYPE", 2, 0, 22),
    # missions
    real("MIS_TAKEOFF_ALT", 2.5, 0.0, 1e4),
    real("MIS_YAW_ERR", 12.0, 0.0, 90.0),
    real("MIS_YAW_TMT", -1.0, -1.0, 20.0),
    # position control
    real("MPC_ACC_DOWN_MAX", 3.0, 0.1, 15.0),
    real("MPC_ACC_HOR", 3.0, 0.1, 15.0),
    real("MPC_ACC_HOR_MAX", 5.0, 0.1, 15.0),
    real("MPC_ACC_UP_MAX", 4.0, 0.1, 15.0),
    real("MPC_LAND_ALT1", 10.0, 0.0, 1e4),
    real("MPC_LAND_ALT2", 5.0, 0.0, 1e4),
    real("MPC_LAND_SPEED", 0.7, 0.1, 15.0),
    real("MPC_TILTMAX_AIR", 45.0, 10.0, 89.0),
    real("MPC_TKO_RAMP_T", 3.0, 0.0, 5.0),
    real("MPC_TKO_SPEED", 1.5, 0.1, 15.0),
    real("MPC_XY_CRUISE", 5.0, 0.1, 30.0),
    real("MPC_XY_VEL_MAX", 12.0, 0.0, 30.0),
    whole("MPC_YAW_MODE", 0, 0, 4),
    real("MPC_Z_VEL_MAX_DN", 1.5, 0.1, 15.0),
    real("MPC_Z_VEL_MAX_UP", 3.0, 0.1, 15.0),
    real("MPC_Z_V_AUTO_DN", 1.5, 0.1, 15.0),
    real("MPC_Z_V_AUTO_UP", 3.0, 0.1, 15.0),
    # navigation
    real("NAV_ACC_RAD", 2.0, 0.05, 200.0),
    whole("NAV_DLL_ACT", 0, 0, 6),
    real("NAV_LOITER_RAD", 80.0, 0.0, 1e4),
    real("NAV_MC_ALT_RAD", 0.8, 0.05, 200.0),
    whole("NAV_RCL_ACT", 2, 0, 6),
    # return
    whole("RTL_CONE_ANG", 45, 0, 90),
    real("RTL_DESCEND_ALT", 10.0, 0.0, 1e4),
    real("RTL_LAND_DELAY", 0.0, -1.0, 1e4),
    real("RTL_MIN_DIST", 10.0, 0.0, 1e4),
    real("RTL_RETURN_ALT", 30.0, 0.0, 1e4),
    whole("RTL_TYPE", 0, 0, 4),
    # system
    whole("SDLOG_MODE", 1),
    whole("SYS_AUTOCONFIG", 0),
    whole("SYS_AUTOSTART", 10040),
    whole("SYS_FAILURE_EN", 0, 0, 1),
    whole("SYS_HAS_BARO", 1),
    whole("SYS_HAS_GPS", 1),
    whole("SYS_HAS_MAG", 1),
    whole("SYS_HITL", 0),
)
"""A multirotor's; autopilots go by these names whatever they show to clients."""

_IN_THE_AIR: Final = ("MPC_", "LNDMC_", "MIS_TAKEOFF", "NAV_MC_", "MAV_TYPE", "SYS_AUTOSTART")
HIDDEN: Final = (*TABLE, whole("POLYGON_FENCES", 1, 0, 1))
"""What autopilots go by."""

COMMON: Final = tuple(each for each in TABLE if not each.name.startswith(_IN_THE_AIR))
"""Those of every kind of vehicle."""


_ROVER_M_S: Final = 12.0
ROVER: Final[tuple[Parameter, ...]] = (
    *COMMON,
    whole("MAV_TYPE", 10, 0, 22),
    real("PP_LOOKAHD_GAIN", 1.0),
    real("PP_LOOKAHD_MAX", 10.0),
    real("PP_LOOKAHD_MIN", 1.0),
    real("RD_TRANS_DRV_TRN", 0.1745),
    real("RD_TRANS_TRN_DRV", 0.0873),
    real("RD_WHEEL_TRACK", 0.5),
    real("RO_ACCEL_LIM", 4.0, -1.0, 100.0),
    real("RO_DECEL_LIM", 4.0, -1.0, 100.0),
    real("RO_JERK_LIM", -1.0, -1.0, 100.0),
    real("RO_MAX_THR_SPEED", _ROVER_M_S, 0.0, 100.0),
    real("RO_SPEED_LIM", _ROVER_M_S, -1.0, 30.0),
    real("RO_SPEED_P", 0.1, 0.0, 100.0),
    real("RO_SPEED_TH", 0.1, 0.0, 100.0),
    real("RO_YAW_P", 5.0, 0.0, 100.0),
    real("RO_YAW_RATE_LIM", 115.0, 0.0, 1e4),
    real("RO_YAW_RATE_TH", 3.0, 0.0, 100.0),
    whole("SYS_AUTOSTART", 50000),
)
"""A differential rover's: the airframe's limits are those of the model."""


def rover(value: Callable[[str], float]) -> Mapping[str, float]:
    """What a rover's parameters mean to the autopilot."""
    limit = value("RO_SPEED_LIM")
    speed = limit if limit > 0 else _ROVER_M_S
    return {
        "MPC_XY_CRUISE": speed,
        "MPC_XY_VEL_MAX": speed,
        "MPC_ACC_HOR": max(value("RO_DECEL_LIM"), 0.1),
    }
