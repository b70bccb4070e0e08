"""Who this end is to an autopilot: a ground station with ids of its own."""

from __future__ import annotations

from typing import Final

from sim_vehicles.codec import Encoder, mav

SYSTEM: Final = 245
COMPONENT: Final = int(mav.MAV_COMP_ID_MISSIONPLANNER)


def heartbeat(encoder: Encoder) -> bytes:
    """This end shows itself."""
    return encoder.pack(
        "HEARTBEAT",
        type=mav.MAV_TYPE_GCS,
        autopilot=mav.MAV_AUTOPILOT_INVALID,
        system_status=mav.MAV_STATE_ACTIVE,
        mavlink_version=3,
    )
