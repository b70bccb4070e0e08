"""Parameters that bite: settings of an autopilot that spoil a mission, by its own names."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Final, TypeAlias

from uavbridge.config import Mission
from uavbridge.doctor.finding import Level
from uavbridge.mavlink.identity import SYSTEM

Test: TypeAlias = Callable[[float, Mission], bool]


@dataclass(frozen=True, slots=True)
class Bite:
    """One parameter that may be set wrong.

    Attributes:
        name: of the parameter.
        bites: whether this value spoils this mission.
        text: what comes of it.
        remedy: what to do.
        level: how bad it is.
    """

    name: str
    bites: Test
    text: str
    remedy: str
    level: Level = Level.WARNING


def _slow(scale: float = 1.0) -> Test:
    return lambda value, mission: 0 < value * scale < mission.safety.speed_m_s


_PX4: Final = (
    Bite(
        "COM_ARM_MIS_REQ", lambda v, _: v > 0,
        "it arms only with a mission uploaded", "set COM_ARM_MIS_REQ to 0", Level.ERROR,
    ),
    Bite(
        "SYS_HITL", lambda v, _: v > 0,
        "it flies simulated sensors (HITL)", "set SYS_HITL to 0 for a real flight",
    ),
    Bite(
        "MPC_XY_VEL_MAX", _slow(),
        "it flies slower than safety.speed_m_s", "raise MPC_XY_VEL_MAX or lower safety.speed_m_s",
    ),
    Bite(
        "MPC_Z_VEL_MAX_UP", lambda v, m: v < m.safety.climb_m_s,
        "it climbs slower than safety.climb_m_s",
        "raise MPC_Z_VEL_MAX_UP or lower safety.climb_m_s",
    ),
    Bite(
        "COM_LOW_BAT_ACT", lambda v, _: v == 0,
        "it does nothing when the battery is low", "set COM_LOW_BAT_ACT to 3 (return, then land)",
    ),
    Bite(
        "COM_DISARM_PRFLT", lambda v, _: 0 < v < 5,
        "it disarms before it can take off", "set COM_DISARM_PRFLT to 10",
    ),
    Bite(
        "COM_RC_IN_MODE", lambda v, _: v == 0,
        "without a remote control it will not arm, or leave offboard",
        "switch the remote on, or set COM_RC_IN_MODE to 1 and bit 2 of COM_RCL_EXCEPT",
    ),
)  # fmt: skip
_ARDUPILOT: Final = (
    Bite(
        "SYSID_ENFORCE", lambda v, _: v > 0,
        "it obeys nobody but SYSID_MYGCS", f"set SYSID_ENFORCE to 0, or SYSID_MYGCS to {SYSTEM}",
    ),
    Bite(
        "ARMING_CHECK", lambda v, _: v == 0,
        "it arms without any checks", "set ARMING_CHECK to 1",
    ),
    Bite(
        "BATT_FS_LOW_ACT", lambda v, _: v == 0,
        "it does nothing when the battery is low", "set BATT_FS_LOW_ACT to 2 (return)",
    ),
)  # fmt: skip
_COPTER: Final = (
    Bite(
        "FRAME_CLASS", lambda v, _: v == 0,
        "its frame is not set, so it never arms", "set FRAME_CLASS", Level.ERROR,
    ),
    Bite(
        "WPNAV_SPEED", _slow(0.01),
        "it flies slower than safety.speed_m_s", "raise WPNAV_SPEED or lower safety.speed_m_s",
    ),
    Bite(
        "DISARM_DELAY", lambda v, _: 0 < v < 5,
        "it disarms before it can take off", "set DISARM_DELAY to 10",
    ),
    Bite(
        "FS_THR_ENABLE", lambda v, _: v == 0,
        "it ignores the loss of its remote control", "set FS_THR_ENABLE to 1",
    ),
)  # fmt: skip
_ROVER: Final = (
    Bite(
        "CRUISE_SPEED", _slow(),
        "it drives slower than safety.speed_m_s", "lower safety.speed_m_s",
    ),
)  # fmt: skip
_PLANE: Final = (
    Bite(
        "RTL_AUTOLAND", lambda v, _: v == 0,
        "should the bridge fall silent, it returns and circles over home, and does not land",
        "give it a landing sequence and set RTL_AUTOLAND, or have a pilot land it",
    ),
    Bite(
        "AIRSPEED_CRUISE", lambda v, m: v > m.safety.speed_m_s,
        "it cruises faster than safety.speed_m_s", "raise safety.speed_m_s: a plane can not slow",
    ),
)  # fmt: skip

BITES: Final[dict[str, tuple[Bite, ...]]] = {
    "PX4": _PX4,
    "ArduCopter": (*_ARDUPILOT, *_COPTER),
    "ArduRover": (*_ARDUPILOT, *_ROVER),
    "ArduPlane": (*_ARDUPILOT, *_PLANE),
}
"""By the name of the flavour."""
