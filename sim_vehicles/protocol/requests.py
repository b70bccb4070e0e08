"""Messages asked for: once, or at a rate."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Final

from sim_vehicles.codec import Packet, mav
from sim_vehicles.modes import Mode
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


def available_modes(endpoint: Endpoint, order: Order) -> int:
    """Send AVAILABLE_MODES of the mode with that index from 1, or of all of them (0)."""
    services, wanted = endpoint.services, order.whole(2)
    modes = sorted(services.craft.modes, key=services.flavour.custom_mode)
    if not services.flavour.answers.tells_modes or not 0 <= wanted <= len(modes):
        return services.flavour.answers.no_message
    for index, mode in enumerate(modes, 1):
        if wanted not in (0, index):
            continue
        standard = _standard(endpoint, mode)
        endpoint.send(
            "AVAILABLE_MODES",
            number_modes=len(modes),
            mode_index=index,
            standard_mode=standard,
            custom_mode=services.flavour.custom_mode(mode),
            properties=0 if mode in _PLAIN_MODES else _ADVANCED,
            mode_name="" if standard else services.craft.modes[mode].name,
        )
    return _ACCEPTED


def current_mode(endpoint: Endpoint, order: Order) -> int:
    """Send CURRENT_MODE."""
    flavour = endpoint.services.flavour
    if not flavour.answers.tells_modes:
        return flavour.answers.no_message
    mode = Mode(int(endpoint.pilot.status.mode[endpoint.index]))
    number = flavour.custom_mode(mode)
    endpoint.send(
        "CURRENT_MODE",
        standard_mode=_standard(endpoint, mode),
        custom_mode=number,
        intended_custom_mode=number,
    )
    return _ACCEPTED


def _standard(endpoint: Endpoint, mode: Mode) -> int:
    """MAV_STANDARD_MODE, as PX4 has it; 0: it is none."""
    kind = endpoint.services.craft.kind
    return _STANDARD_OF.get(kind, {}).get(mode, _STANDARD.get(mode, 0))


_PLAIN_MODES: Final = (Mode.ALTITUDE, Mode.POSITION)
_ADVANCED: Final = 1  # MAV_MODE_PROPERTY_ADVANCED
_AVAILABLE_MODES, _CURRENT_MODE = 435, 436  # not in the dialect yet
_STANDARD: Final[Mapping[Mode, int]] = {
    Mode.RETURN: mav.MAV_STANDARD_MODE_SAFE_RECOVERY,
    Mode.MISSION: mav.MAV_STANDARD_MODE_MISSION,
    Mode.LAND: mav.MAV_STANDARD_MODE_LAND,
    Mode.TAKEOFF: mav.MAV_STANDARD_MODE_TAKEOFF,
}
_STANDARD_OF: Final[Mapping[str, Mapping[Mode, int]]] = {
    "multirotor": {
        Mode.ALTITUDE: mav.MAV_STANDARD_MODE_ALTITUDE_HOLD,
        Mode.POSITION: mav.MAV_STANDARD_MODE_POSITION_HOLD,
    },
    "plane": {
        Mode.ALTITUDE: mav.MAV_STANDARD_MODE_ALTITUDE_HOLD,
        Mode.POSITION: mav.MAV_STANDARD_MODE_CRUISE,
    },
}
_OWN: Final[dict[int, Callable[[Endpoint, Order], int]]] = {
    mav.MAVLINK_MSG_ID_AUTOPILOT_VERSION: autopilot_version,
    _AVAILABLE_MODES: available_modes,
    _CURRENT_MODE: current_mode,
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
