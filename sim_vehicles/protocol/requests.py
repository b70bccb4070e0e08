"""Messages asked for: once, or at a rate."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

from sim_vehicles.codec import Packet, mav
from sim_vehicles.protocol.endpoint import Endpoint
from sim_vehicles.protocol.orders import Order

_ACCEPTED: Final[int] = mav.MAV_RESULT_ACCEPTED
_DENIED: Final[int] = mav.MAV_RESULT_DENIED
_FASTEST_HZ: Final = 50
_CRITICAL: Final = 2
_NAK: Final = 129
_UNKNOWN_COMMAND: Final = 7


def autopilot_version(endpoint: Endpoint, order: Order) -> int:
    """Send AUTOPILOT_VERSION."""
    flavour = endpoint.services.flavour
    endpoint.send(
        "AUTOPILOT_VERSION",
        capabilities=flavour.capabilities,
        flight_sw_version=flavour.version,
        middleware_sw_version=flavour.version,
        board_version=1,
        uid=endpoint.system,
    )
    return _ACCEPTED


def home_position(endpoint: Endpoint, order: Order) -> int:
    """Send HOME_POSITION."""
    return _telemetry(endpoint, "HOME_POSITION")


def prearm_checks(endpoint: Endpoint, order: Order) -> int:
    """RUN_PREARM_CHECKS: a text says what is wrong."""
    reason = endpoint.pilot.why_not_arm(endpoint.index)
    if reason is not None:
        endpoint.pilot.say(endpoint.index, _CRITICAL, f"PreArm: {reason}")
    return _ACCEPTED


def on_log_list(endpoint: Endpoint, packet: Packet) -> None:
    """LOG_REQUEST_LIST: there are none."""
    endpoint.send("LOG_ENTRY")


def on_file(endpoint: Endpoint, packet: Packet) -> None:
    """FILE_TRANSFER_PROTOCOL: refused at once, so that nobody waits for files."""
    asked = bytes(packet.message.payload)
    number = (int.from_bytes(asked[:2], "little") + 1) & 0xFFFF
    answer = bytearray(len(asked))
    answer[:2] = number.to_bytes(2, "little")
    answer[2:6] = asked[2], _NAK, 1, asked[3]
    answer[12] = _UNKNOWN_COMMAND
    endpoint.send(
        "FILE_TRANSFER_PROTOCOL",
        target_network=0,
        target_system=packet.system,
        target_component=packet.component,
        payload=bytes(answer),
    )


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
    if generated is None:
        return endpoint.services.flavour.answers.no_message
    return _telemetry(endpoint, generated.msgname)


def _telemetry(endpoint: Endpoint, name: str) -> int:
    known = name != "HOME_POSITION" or endpoint.pilot.has_home(endpoint.index)
    if known and endpoint.show(name):
        return _ACCEPTED
    return endpoint.services.flavour.answers.no_message


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
    message = packet.message
    rate_hz = message.req_message_rate if message.start_stop else 0
    everything = message.req_stream_id == mav.MAV_DATA_STREAM_ALL
    parameters = endpoint.pilot.parameters
    for stream, (parameter, _) in endpoint.services.flavour.data_streams.items():
        if everything or stream == message.req_stream_id:
            parameters.set(endpoint.index, parameter, min(rate_hz, _FASTEST_HZ))
            set_group(endpoint, stream)


def set_group(endpoint: Endpoint, stream: int) -> None:
    """Stream a group of messages at the rate that its parameter says."""
    parameter, names = endpoint.services.flavour.data_streams[stream]
    rate_hz = endpoint.pilot.parameters.get(endpoint.index, parameter)
    interval_us = round(1e6 / rate_hz) if rate_hz > 0 else -1
    for name in names:
        msgid = getattr(mav, f"MAVLINK_MSG_ID_{name}")
        endpoint.services.telemetry.set_interval(endpoint.index, msgid, interval_us)
