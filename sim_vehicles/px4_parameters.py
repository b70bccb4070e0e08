"""PX4's parameters that this autopilot acts on or that clients ask for, with PX4's defaults.

Values are those of a PX4 1.17 quadrotor. Ranges are what the autopilot can fly with.
"""

from __future__ import annotations

from typing import Final

from sim_vehicles.params import Parameter, Type


def _whole(name: str, default: int, low: int = -(2**31), high: int = 2**31 - 1) -> Parameter:
    return Parameter(name, Type.INT32, default, low, high)


def _real(name: str, default: float, low: float = -1e6, high: float = 1e6) -> Parameter:
    return Parameter(name, Type.REAL32, default, low, high)


TABLE: Final[tuple[Parameter, ...]] = (
    # power
    _real("BAT1_CAPACITY", -1.0),
    _whole("BAT1_N_CELLS", 4, 0, 16),
    _whole("BAT1_SOURCE", 0),
    _real("BAT1_V_CHARGED", 4.05),
    _real("BAT1_V_EMPTY", 3.6),
    _real("BAT_CRIT_THR", 0.07, 0.0, 1.0),
    _real("BAT_EMERGEN_THR", 0.05, 0.0, 1.0),
    _real("BAT_LOW_THR", 0.15, 0.0, 1.0),
    # circuit breakers
    _whole("CBRK_FLIGHTTERM", 121212),
    _whole("CBRK_IO_SAFETY", 22027),
    _whole("CBRK_SUPPLY_CHK", 0),
    _whole("CBRK_USB_CHK", 197848),
    # arming, disarming, failsafes
    _whole("COM_ARMABLE", 1, 0, 1),
    _real("COM_ARM_BAT_MIN", -1.0, -1.0, 0.9),
    _whole("COM_ARM_MIS_REQ", 0, 0, 1),
    _whole("COM_ARM_WO_GPS", 1, 0, 2),
    _real("COM_DISARM_LAND", 2.0, -1.0, 1e4),
    _real("COM_DISARM_PRFLT", 10.0, -1.0, 1e4),
    _whole("COM_DL_LOSS_T", 10, 1, 300),
    _real("COM_FAIL_ACT_T", 5.0, 0.0, 25.0),
    _whole("COM_FLIGHT_UUID", 0),
    _whole("COM_LOW_BAT_ACT", 3, 0, 3),
    _whole("COM_OBL_RC_ACT", 0, 0, 7),
    _real("COM_OF_LOSS_T", 1.0, 0.0, 60.0),
    _whole("COM_RCL_EXCEPT", 0),
    _whole("COM_RC_IN_MODE", 1),
    _real("COM_RC_LOSS_T", 0.5),
    _real("COM_SPOOLUP_TIME", 1.0, 0.0, 30.0),
    _whole("COM_TAKEOFF_ACT", 0, 0, 1),
    # geofence
    _whole("GF_ACTION", 2, 0, 5),
    _real("GF_MAX_HOR_DIST", 0.0, 0.0, 1e5),
    _real("GF_MAX_VER_DIST", 0.0, 0.0, 1e5),
    _whole("GF_PREDICT", 0, 0, 1),
    _whole("GF_SOURCE", 0, 0, 1),
    # land detector
    _real("LNDMC_TRIG_TIME", 1.0, 0.1, 10.0),
    # identity
    _whole("MAV_COMP_ID", 1, 1, 250),
    _whole("MAV_PROTO_VER", 2, 0, 2),
    _whole("MAV_SYS_ID", 1, 1, 255),
    _whole("MAV_TYPE", 2, 0, 22),
    # missions
    _real("MIS_TAKEOFF_ALT", 2.5, 0.0, 1e4),
    _real("MIS_YAW_ERR", 12.0, 0.0, 90.0),
    _real("MIS_YAW_TMT", -1.0, -1.0, 20.0),
    # position control
    _real("MPC_ACC_DOWN_MAX", 3.0, 0.1, 15.0),
    _real("MPC_ACC_HOR", 3.0, 0.1, 15.0),
    _real("MPC_ACC_HOR_MAX", 5.0, 0.1, 15.0),
    _real("MPC_ACC_UP_MAX", 4.0, 0.1, 15.0),
    _real("MPC_LAND_ALT1", 10.0, 0.0, 1e4),
    _real("MPC_LAND_ALT2", 5.0, 0.0, 1e4),
    _real("MPC_LAND_SPEED", 0.7, 0.1, 15.0),
    _real("MPC_TILTMAX_AIR", 45.0, 10.0, 89.0),
    _real("MPC_TKO_RAMP_T", 3.0, 0.0, 5.0),
    _real("MPC_TKO_SPEED", 1.5, 0.1, 15.0),
    _real("MPC_XY_CRUISE", 5.0, 0.1, 30.0),
    _real("MPC_XY_VEL_MAX", 12.0, 0.0, 30.0),
    _whole("MPC_YAW_MODE", 0, 0, 4),
    _real("MPC_Z_VEL_MAX_DN", 1.5, 0.1, 15.0),
    _real("MPC_Z_VEL_MAX_UP", 3.0, 0.1, 15.0),
    _real("MPC_Z_V_AUTO_DN", 1.5, 0.1, 15.0),
    _real("MPC_Z_V_AUTO_UP", 3.0, 0.1, 15.0),
    # navigation
    _real("NAV_ACC_RAD", 2.0, 0.05, 200.0),
    _whole("NAV_DLL_ACT", 0, 0, 6),
    _real("NAV_LOITER_RAD", 80.0, 0.0, 1e4),
    _real("NAV_MC_ALT_RAD", 0.8, 0.05, 200.0),
    _whole("NAV_RCL_ACT", 2, 0, 6),
    # return
    _whole("RTL_CONE_ANG", 45, 0, 90),
    _real("RTL_DESCEND_ALT", 10.0, 0.0, 1e4),
    _real("RTL_LAND_DELAY", 0.0, -1.0, 1e4),
    _real("RTL_MIN_DIST", 10.0, 0.0, 1e4),
    _real("RTL_RETURN_ALT", 30.0, 0.0, 1e4),
    _whole("RTL_TYPE", 0, 0, 4),
    # system
    _whole("SDLOG_MODE", 1),
    _whole("SYS_AUTOCONFIG", 0),
    _whole("SYS_AUTOSTART", 10040),
    _whole("SYS_HAS_BARO", 1),
    _whole("SYS_HAS_GPS", 1),
    _whole("SYS_HAS_MAG", 1),
    _whole("SYS_HITL", 0),
)
