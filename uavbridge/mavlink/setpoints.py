"""Setpoints as SET_POSITION_TARGET_LOCAL_NED wants them."""

from __future__ import annotations

import logging
from math import isfinite
from typing import Final, TypeAlias

from uavbridge.mavlink.local_frame import LocalFrame, heading_to_yaw
from uavbridge.vehicle.api import SetPosition, SetVelocity

logger = logging.getLogger(__name__)

Setpoint: TypeAlias = dict[str, float]
"""Fields of the message: those of the setpoint, and ``type_mask``."""

_NO_POSITION: Final = 0x007
_NO_VELOCITY: Final = 0x038
_NO_ACCELERATION: Final = 0x1C0
_NO_YAW: Final = 0x400
_NO_YAW_RATE: Final = 0x800


def standstill() -> Setpoint:
    """Zero velocity."""
    return {"type_mask": _NO_POSITION | _NO_ACCELERATION | _NO_YAW | _NO_YAW_RATE}


def setpoint_of(command: SetVelocity | SetPosition, frame: LocalFrame | None) -> Setpoint | None:
    """Fields for a setpoint; None: a position while the vehicle's frame is not known.

    Raises:
        ValueError: a number that is not finite. To an autopilot it would mean "uncontrolled".
    """
    mask = _NO_ACCELERATION | _NO_YAW_RATE
    if isinstance(command, SetVelocity):
        mask |= _NO_POSITION
        x, y, z = command.velocity.tolist()
        n, e, d = (y, x, -z) if frame is None else frame.velocity_to_local(x, y, z)
        fields = {"vx": n, "vy": e, "vz": d}
    else:
        mask |= _NO_VELOCITY
        x, y, z = command.position.tolist()
        if frame is None:
            logger.debug("dropped a position: the vehicle's local frame is not known yet")
            return None
        n, e, d = frame.to_local(x, y, z)
        fields = {"x": n, "y": e, "z": d}
    if not isfinite(n + e + d):
        raise ValueError(f"a setpoint must be finite, not {(x, y, z)}")
    if command.yaw_rad is None:
        mask |= _NO_YAW
    elif not isfinite(command.yaw_rad):
        raise ValueError(f"a yaw must be finite, not {command.yaw_rad}")
    else:
        fields["yaw"] = heading_to_yaw(command.yaw_rad)
    fields["type_mask"] = mask
    return fields
