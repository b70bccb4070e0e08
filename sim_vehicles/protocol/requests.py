"""Messages asked for: once, or at a rate."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from sim_vehicles.codec import Packet, mav
from sim_vehicles.protocol.endpoint import Endpoint
from sim_vehicles.protocol.orders import Order

_ACCEPTED: Final[int] = mav.MAV_RESULT_ACCEPTED
_DENIED: Final[int] = mav.MAV_RESULT_DENIED
_VERSION: Final = 0x01_11_00_FF  # 1.17.0, a release
_CAPABILITIES: Final[int] = (
    mav.MAV_PROTOCOL_CAPABILITY_MISSION_FLOAT
    | mav.MAV_PROTOCOL_CAPABILITY_MISSION_INT
    | mav.MAV_PROTOCOL_CAPABILITY_COMMAND_INT
    | mav.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_LOCAL_NED
    | mav.MAV_PROTOCOL_CAPABILITY_SET_POSITION_TARGET_GLOBAL_INT
    | mav.MAV_PROTOCOL_CAPABILITY_FLIGHT_TERMINATION
    | mav.MAV_PROTOCOL_CAPABILITY_MAVLINK2
    | mav.MAV_PROTOCOL_CAPABILITY_MISSION_FENCE
    | mav.MAV_PROTOCOL_CAPABILITY_MISSION_RALLY
)
_STREAMS: Final[dict[int, tuple[str, ...]]] = {
    mav.MAV_DATA_STREAM_RAW_SENSORS: ("GPS_RAW_INT",),
    mav.MAV_DATA_STREAM_EXTENDED_STATUS: ("SYS_STATUS", "BATTERY_STATUS", "MISSION_CURRENT"),
    mav.MAV_DATA_STREAM_POSITION: ("GLOBAL_POSITION_INT", "LOCAL_POSITION_NED"),
    mav.MAV_DATA_STREAM_EXTRA1: ("ATTITUDE",),
    mav.MAV_DATA_STREAM_EXTRA2: ("VFR_HUD",),
    mav.MAV_DATA_STREAM_EXTRA3: ("SYSTEM_TIME",),
}


def autopilot_version(endpoint: Endpoint, order: Order) -> int:
    """Send AUTOPILOT_VERSION."""
    endpoint.send(
        "AUTOPILOT_VERSION",
        capabilities=_CAPABILITIES | endpoint.services.flavour.capabilities,
        flight_sw_version=_VERSION,
        middleware_sw_version=_VERSION,
        board_version=1,
        uid=endpoint.system,
    )
    return _ACCEPTED


def home_position(endpoint: Endpoint, order: Order) -> int:
    """Send HOME_POSITION."""
    return _telemetry(endpoint, "HOME_POSITION")


_OWN: Final[dict[int, Callable[[Endpoint, Order], int]]] = {
    mav.MAVLINK_MSG_ID_AUTOPILOT_VERSION: autopilot_version,
}


def request_message(endpoint: Endpoint, order: Order) -> int:
    """Send one message now; DENIED, as by PX4, if it can not be had."""
    wanted = order.whole(1, -1)
    own = _OWN.get(wanted)
    if own is not None:
        return own(endpoint, order)
    generated = mav.mavlink_map.get(wanted)
    return _DENIED if generated is None else _telemetry(endpoint, generated.msgname)


def _telemetry(endpoint: Endpoint, name: str) -> int:
    services = endpoint.services
    services.report.update()
    snapshot = services.report.snapshot
    frame = services.telemetry.one(endpoint.index, name, endpoint.now_us, snapshot)
    if frame is None:
        return _DENIED
    endpoint.out.append(frame)
    return _ACCEPTED


def set_interval(endpoint: Endpoint, order: Order) -> int:
    """SET_MESSAGE_INTERVAL: microseconds, -1 off, 0 the default."""
    interval_us = max(order.whole(2), -1)
    known = endpoint.services.telemetry.set_interval(
        endpoint.index, order.whole(1, -1), interval_us
    )
    return _ACCEPTED if known else _DENIED


def get_interval(endpoint: Endpoint, order: Order) -> int:
    """GET_MESSAGE_INTERVAL: send MESSAGE_INTERVAL."""
    wanted = order.whole(1, -1)
    if not 0 <= wanted <= 0xFFFF:
        return _DENIED
    interval_us = endpoint.services.telemetry.interval(endpoint.index, wanted)
    endpoint.send("MESSAGE_INTERVAL", message_id=wanted, interval_us=interval_us)
    return _ACCEPTED


def on_data_stream(endpoint: Endpoint, packet: Packet) -> None:
    """REQUEST_DATA_STREAM: rates of groups of messages, where the autopilot heeds it."""
    if not endpoint.services.flavour.heeds_data_streams:
        return
    message = packet.message
    everything = message.req_stream_id == mav.MAV_DATA_STREAM_ALL
    on = message.start_stop and message.req_message_rate
    interval_us = 1_000_000 // message.req_message_rate if on else -1
    for stream, names in _STREAMS.items():
        for name in names if everything or stream == message.req_stream_id else ():
            msgid = getattr(mav, f"MAVLINK_MSG_ID_{name}")
            endpoint.services.telemetry.set_interval(endpoint.index, msgid, interval_us)
