"""PX4's parameters of fixed-wing aircraft that are acted on here or that clients ask for.

Defaults are PX4 1.17's but for the airframe's own: airspeeds, climb and loiter radius fit the
Aerosonde of ``sim_vehicles.dynamics.plane``.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from sim_vehicles.params import Parameter
from sim_vehicles.px4_parameters import COMMON, real, whole

_OWN: Final[tuple[Parameter, ...]] = (
    real("FW_AIRSPD_MAX", 70.0, 20.0, 75.0),
    real("FW_AIRSPD_MIN", 20.0, 18.0, 70.0),
    real("FW_AIRSPD_STALL", 15.0, 0.5, 70.0),
    real("FW_AIRSPD_TRIM", 35.0, 20.0, 75.0),
    real("FW_LND_AIRSPD", 24.0, -1.0, 75.0),
    real("FW_LND_ANG", 5.0, 1.0, 15.0),
    real("FW_LND_FLALT", 5.0, 0.0, 50.0),
    real("FW_LND_FL_SINK", 0.5, 0.1, 2.0),
    real("FW_P_LIM_MAX", 30.0, 0.0, 60.0),
    real("FW_P_LIM_MIN", -30.0, -60.0, 0.0),
    real("FW_R_LIM", 55.0, 35.0, 65.0),
    real("FW_THR_TRIM", 0.46, 0.0, 1.0),
    real("FW_TKO_AIRSPD", -1.0, -1.0, 75.0),
    real("FW_T_ALT_TC", 2.0, 0.5, 50.0),
    real("FW_T_CLMB_MAX", 8.0, 1.0, 30.0),
    real("FW_T_CLMB_R_SP", 6.0, 0.5, 30.0),
    real("FW_T_SINK_MAX", 8.0, 1.0, 30.0),
    real("FW_T_SINK_R_SP", 5.0, 0.5, 30.0),
    real("LNDFW_TRIG_TIME", 2.0, 0.1, 10.0),
    whole("MAV_TYPE", 1, 0, 22),
    real("MIS_LND_ABRT_ALT", 30.0, 0.0, 1e4),
    real("MIS_TAKEOFF_ALT", 30.0, 0.0, 1e4),
    real("NAV_ACC_RAD", 10.0, 0.05, 200.0),
    real("NAV_FW_ALT_RAD", 10.0, 0.05, 200.0),
    real("NAV_LOITER_RAD", 150.0, -1e4, 1e4),
    real("NPFG_PERIOD", 10.0, 1.0, 100.0),
    real("RTL_DESCEND_ALT", 60.0, 0.0, 1e4),
    real("RTL_LAND_DELAY", -1.0, -1.0, 1e4),
    real("RTL_LOITER_RAD", 150.0, 25.0, 1e4),
    real("RTL_RETURN_ALT", 100.0, 0.0, 1e4),
    real("RWTO_TKOFF", 1.0, 0.0, 1.0),
    whole("SYS_AUTOSTART", 2100),
)
_NAMES: Final = frozenset(each.name for each in _OWN)

PX4: Final[tuple[Parameter, ...]] = (*_OWN, *(each for each in COMMON if each.name not in _NAMES))


def px4(value: Callable[[str], float]) -> Mapping[str, float]:
    """What a plane's parameters mean to the autopilot."""
    return {
        "MPC_XY_CRUISE": value("FW_AIRSPD_TRIM"),
        "MPC_XY_VEL_MAX": value("FW_AIRSPD_MAX"),
        "MPC_Z_V_AUTO_UP": value("FW_T_CLMB_R_SP"),
        "MPC_Z_V_AUTO_DN": value("FW_T_SINK_R_SP"),
        "MPC_Z_VEL_MAX_UP": value("FW_T_CLMB_MAX"),
        "MPC_Z_VEL_MAX_DN": value("FW_T_SINK_MAX"),
        "MPC_TKO_SPEED": value("FW_T_CLMB_MAX"),
        "NAV_MC_ALT_RAD": value("NAV_FW_ALT_RAD"),
        "LNDMC_TRIG_TIME": value("LNDFW_TRIG_TIME"),
    }
