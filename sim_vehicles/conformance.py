"""What the simulated vehicles answer, found out by asking them: the page of the reference.

Every row is an exchange with a vehicle as clients meet it, one vehicle a row and column.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Iterator, Mapping, Sequence
from math import nan
from typing import Any, Final

from sim_vehicles.codec import Counts, Encoder, decode, mav
from sim_vehicles.craft import Craft
from sim_vehicles.crafts import CRAFTS
from sim_vehicles.fleet import Fleet, VehicleSpec
from sim_vehicles.geodesy import Geodetic
from sim_vehicles.modes import Mode
from sim_vehicles.protocol.commands import COMMANDS
from sim_vehicles.protocol.items import Item, why_not
from sim_vehicles.protocol.services import HANDLERS

_HOME: Final = Geodetic(47.397742, 8.545594, 488.0)
_LATITUDE, _LONGITUDE = round(_HOME.latitude_deg * 1e7), round(_HOME.longitude_deg * 1e7)
_NAMES: Final = {"multirotor": "copter", "rover": "rover", "plane": "plane"}
_STATION: Final = 255, 190
_MANY: Final = 4  # messages: a stream begins
_RESULTS: Final = mav.enums["MAV_RESULT"]
_ASKED: Final[Mapping[int, tuple[float, ...]]] = {
    mav.MAV_CMD_NAV_TAKEOFF: (0, 0, 0, nan, nan, nan, 20),
    mav.MAV_CMD_CONDITION_YAW: (90, 0, 1),
    mav.MAV_CMD_DO_CHANGE_SPEED: (1, 5, -1),
    mav.MAV_CMD_DO_ORBIT: (100, 0, 0, nan, 47.3978, 8.5456, 600),
    mav.MAV_CMD_DO_CHANGE_ALTITUDE: (600,),
    mav.MAV_CMD_DO_SET_HOME: (1,),
    mav.MAV_CMD_DO_REPOSITION: (-1, 1, 0, nan, 47.3978, 8.5456, 20),
    mav.MAV_CMD_COMPONENT_ARM_DISARM: (1,),
    mav.MAV_CMD_DO_FENCE_ENABLE: (1,),
    mav.MAV_CMD_PREFLIGHT_REBOOT_SHUTDOWN: (1,),
    mav.MAV_CMD_GET_MESSAGE_INTERVAL: (30,),
    mav.MAV_CMD_SET_MESSAGE_INTERVAL: (30, 100_000),
    mav.MAV_CMD_REQUEST_MESSAGE: (148,),
}
"""Params of each command as it is tried; otherwise zeros."""
_OTHERS: Final = (
    *(mav.MAV_CMD_DO_SET_ROI_LOCATION, mav.MAV_CMD_DO_SET_STANDARD_MODE),
    *(mav.MAV_CMD_REQUEST_CAMERA_INFORMATION, mav.MAV_CMD_REQUEST_PROTOCOL_VERSION),
    *(mav.MAV_CMD_REQUEST_STORAGE_INFORMATION, mav.MAV_CMD_PREFLIGHT_CALIBRATION),
)
"""Commands that clients send and that nothing here knows."""
_ITEM: Final = {
    "frame": mav.MAV_FRAME_GLOBAL_RELATIVE_ALT,
    "command": mav.MAV_CMD_NAV_WAYPOINT,
    "z": 10.0,
}
_MESSAGES: Final[Mapping[str, dict[str, Any]]] = {
    "HEARTBEAT": {"type": mav.MAV_TYPE_GCS},
    "PING": {"target_system": 0, "target_component": 0},
    "TIMESYNC": {"ts1": 1},
    "COMMAND_LONG": {"command": mav.MAV_CMD_RUN_PREARM_CHECKS},
    "COMMAND_INT": {"command": mav.MAV_CMD_RUN_PREARM_CHECKS},
    "REQUEST_DATA_STREAM": {"req_message_rate": 2, "start_stop": 1},
    "PARAM_REQUEST_READ": {"param_index": 0},
    "MISSION_COUNT": {"count": 2},
    "MISSION_ITEM": {**_ITEM, "x": _HOME.latitude_deg, "y": _HOME.longitude_deg},
    "MISSION_ITEM_INT": {**_ITEM, "x": _LATITUDE, "y": _LONGITUDE},
    "FILE_TRANSFER_PROTOCOL": {"payload": bytes(251)},
}
"""Fields of each message as it is tried; the others are zero."""
_ITEMS: Final = (
    *("NAV_WAYPOINT", "NAV_TAKEOFF", "NAV_LAND", "NAV_LOITER_UNLIM", "NAV_LOITER_TIME"),
    *("NAV_LOITER_TO_ALT", "NAV_LOITER_TURNS", "NAV_SPLINE_WAYPOINT", "NAV_RETURN_TO_LAUNCH"),
    *("NAV_DELAY", "DO_JUMP", "DO_CHANGE_SPEED", "CONDITION_DELAY", "CONDITION_YAW"),
    *("DO_SET_HOME", "DO_SET_SERVO", "DO_SET_ROI", "DO_LAND_START", "IMAGE_START_CAPTURE"),
    *("SET_CAMERA_MODE", "DO_GIMBAL_MANAGER_PITCHYAW", "DO_GIMBAL_MANAGER_CONFIGURE"),
)
_REQUESTED: Final = {
    **{"AUTOPILOT_VERSION": 148, "PROTOCOL_VERSION": 300, "AVAILABLE_MODES": 435},
    **{"CURRENT_MODE": 436, "COMPONENT_METADATA": 397, "COMPONENT_INFORMATION": 395},
    **{"CAMERA_INFORMATION": 259, "GIMBAL_MANAGER_INFORMATION": 280, "HOME_POSITION": 242},
}
"""Messages that ground stations ask for by REQUEST_MESSAGE when they meet a vehicle."""


def page() -> str:
    """docs/reference/conformance.md."""
    return "\n".join([_INTRODUCTION, *_sections()])


def _sections() -> Iterator[str]:
    commands = {_command(number): number for number in sorted((*COMMANDS, *_OTHERS))}
    answers = {craft: _answers(craft, sorted(HANDLERS)) for craft in CRAFTS.values()}
    results = {craft: _results(craft, commands) for craft in CRAFTS.values()}
    requested = {craft: _requested(craft) for craft in CRAFTS.values()}
    names = {name for craft in CRAFTS.values() for name in craft.flavour.fills}
    yield from ("## Messages", "", _MESSAGES_TEXT, "")
    yield from _table("message", sorted(HANDLERS), lambda craft, name: answers[craft][name])
    yield from ("", "## Commands", "", _COMMANDS_TEXT, "")
    yield from _table("command", list(commands), lambda craft, name: results[craft][name])
    yield from ("", "## Requests", "", _REQUESTS_TEXT, "")
    yield from _table("message", list(_REQUESTED), lambda craft, name: requested[craft][name])
    yield from ("", "## Modes", "", _MODES_TEXT, "")
    yield from _table("here", [mode.name.lower() for mode in Mode], _mode)
    yield from ("", "## Telemetry", "", _TELEMETRY_TEXT, "")
    yield from _table("message", sorted(names), _rate)
    yield from ("", "## Mission items", "", _ITEMS_TEXT, "")
    yield from _table("item", list(_ITEMS), _taken)
    yield ""


def _table(head: str, rows: Sequence[str], cell: Callable[[Craft, str], str]) -> Iterator[str]:
    crafts = list(CRAFTS.values())
    columns = [f"{craft.autopilot} {_NAMES[craft.kind]}" for craft in crafts]
    yield f"| {head} | " + " | ".join(columns) + " |"
    yield "| --- " * (len(crafts) + 1) + "|"
    for row in rows:
        yield f"| {row} | " + " | ".join(cell(craft, row) for craft in crafts) + " |"


def _vehicles(craft: Craft, count: int, *, flying: bool = False) -> Fleet:
    """Vehicles that are ready; flying (rovers: armed) or on the ground, disarmed."""
    in_air_m = 30.0 if flying and craft.kind != "rover" else None
    specs = [
        VehicleSpec(
            system=i + 1,
            start=(100.0 * i, 0.0, 0.0),
            kind=craft.kind,
            autopilot=craft.autopilot,
            in_air_m=in_air_m,
        )
        for i in range(count)
    ]
    fleet = Fleet(specs, origin=_HOME, model="perfect")
    fleet.pilot.status.ready_us[:] = 0
    if flying and in_air_m is None:
        for i in range(count):
            fleet.pilot.arm(i)
    fleet.advance(100_000)
    fleet.transmit()
    return fleet


def _heard(fleet: Fleet) -> dict[int, list[Any]]:
    """What has come since the last call, by vehicle."""
    heard: dict[int, list[Any]] = defaultdict(list)
    for i, datagram in fleet.transmit():
        heard[i].extend(packet.message for packet in decode(datagram, Counts()))
    return heard


def _answers(craft: Craft, names: Sequence[str]) -> dict[str, str]:
    """What answers each message, at once or within half a second, each from another vehicle."""
    fleet, sender = _vehicles(craft, len(names)), Encoder(*_STATION)
    for i, name in enumerate(names):
        if name.startswith("MISSION_ITEM"):
            fleet.receive(i, sender.pack("MISSION_COUNT", **_addressed(name, i), count=1))
    fleet.transmit()
    for i, name in enumerate(names):
        fields = _addressed(name, i) | _fields(craft, name)
        fleet.receive(i, sender.pack(name, **fields))
    at_once = _heard(fleet)
    fleet.advance(600_000)
    later = _heard(fleet)
    answers = {}
    for i, name in enumerate(names):
        fresh = [each for each in later[i] if each.msgname not in craft.flavour.intervals_us]
        got = list(dict.fromkeys(each.msgname for each in at_once[i] + fresh))
        answers[name] = ", ".join(got) if len(got) < _MANY else "telemetry"
    return {name: answer or "-" for name, answer in answers.items()}


def _fields(craft: Craft, name: str) -> dict[str, Any]:
    if name == "PARAM_SET":
        known = craft.parameters[0]
        value = craft.flavour.encoded(known.type, known.default)
        return {"param_id": known.name, "param_type": int(known.type), "param_value": value}
    return dict(_MESSAGES.get(name, {}))


def _addressed(name: str, i: int) -> dict[str, int]:
    """Target fields, of a message that has them."""
    names = mav.mavlink_map[getattr(mav, f"MAVLINK_MSG_ID_{name}")].fieldnames
    return {field: value for field, value in _to(i).items() if field in names}


def _to(i: int) -> dict[str, int]:
    return {"target_system": i + 1, "target_component": 1}


def _results(craft: Craft, commands: Mapping[str, int]) -> dict[str, str]:
    """On the ground, and in flight where that is another one; each command to another vehicle."""
    found: list[list[str]] = []
    for flying in (False, True):
        fleet, sender = _vehicles(craft, len(commands), flying=flying), Encoder(*_STATION)
        for i, command in enumerate(commands.values()):
            params = (*_ASKED.get(command, ()), *[0.0] * 7)[:7]
            if command == mav.MAV_CMD_DO_SET_MODE:
                params = (1.0, *_hold(craft), *[0.0] * 4)
            fields = {f"param{number}": value for number, value in enumerate(params, 1)}
            fleet.receive(i, sender.pack("COMMAND_LONG", **_to(i), command=command, **fields))
        heard = _heard(fleet)
        found.append([_result(heard[i]) for i in range(len(commands))])
    return {
        name: first if first == then else f"{first}; in flight {then}"
        for name, first, then in zip(commands, *found, strict=True)
    }


def _requested(craft: Craft) -> dict[str, str]:
    """The result of REQUEST_MESSAGE, each to another vehicle on the ground."""
    fleet, sender = _vehicles(craft, len(_REQUESTED)), Encoder(*_STATION)
    request = mav.MAV_CMD_REQUEST_MESSAGE
    for i, message in enumerate(_REQUESTED.values()):
        fleet.receive(i, sender.pack("COMMAND_LONG", **_to(i), command=request, param1=message))
    heard = _heard(fleet)
    return {name: _result(heard[i]) for i, name in enumerate(_REQUESTED)}


def _result(heard: Sequence[Any]) -> str:
    """What the acknowledgement says."""
    ack = next(each for each in heard if each.msgname == "COMMAND_ACK")
    name = str(_RESULTS[ack.result].name)
    return name.removeprefix("MAV_RESULT_").lower().replace("_", " ")


def _hold(craft: Craft) -> tuple[float, float]:
    number = craft.flavour.custom_mode(Mode.HOLD)
    px4 = craft.autopilot == "px4"
    return (float(number >> 16 & 255), float(number >> 24)) if px4 else (float(number), 0.0)


def _command(number: int) -> str:
    return str(mav.enums["MAV_CMD"][number].name).removeprefix("MAV_CMD_")


def _mode(craft: Craft, name: str) -> str:
    mode = Mode[name.upper()]
    if mode not in craft.modes:
        return "-"
    return f"{craft.modes[mode].name} ({craft.flavour.custom_mode(mode)})"


def _rate(craft: Craft, name: str) -> str:
    if name not in craft.flavour.fills:
        return "-"
    interval_us = craft.flavour.intervals_us.get(name, 0)
    if interval_us:
        return f"{1e6 / interval_us:g} Hz"
    groups = [group for group, names in craft.flavour.data_streams.values() if name in names]
    return groups[0] if groups else "asked for"


def _taken(craft: Craft, name: str) -> str:
    """MAV_MISSION_RESULT of an item, as a place and as an order; the better one."""
    command = getattr(mav, f"MAV_CMD_{name}")
    results = [
        why_not(
            Item(frame, command, 0, 1, 1.0, 0.0, 0.0, 0.0, _LATITUDE, _LONGITUDE, 10.0),
            int(mav.MAV_MISSION_TYPE_MISSION),
            any_frame=craft.flavour.home_first,
        )
        for frame in (int(mav.MAV_FRAME_GLOBAL_RELATIVE_ALT), int(mav.MAV_FRAME_MISSION))
    ]
    result = mav.enums["MAV_MISSION_RESULT"][min(results)].name
    return str(result).removeprefix("MAV_MISSION_").lower()


_INTRODUCTION: Final = """\
# What the simulated vehicles answer

Made by asking them (`python docs/generate.py`); a test asks again. Each column is a vehicle of
`python -m sim_vehicles --autopilot px4|ardupilot --kind copter|rover|plane`. The faces are those
of PX4 1.17 and ArduPilot 4.6.3. [The simulator](simulator.md) tells what they do otherwise than
the real ones.
"""
_MESSAGES_TEXT: Final = """\
What comes back when a message is sent to a vehicle on the ground, ready and disarmed; "-": no
answer, as setpoints and heartbeats have none. Messages that are not listed are passed over."""
_COMMANDS_TEXT: Final = """\
The result in COMMAND_ACK, of a COMMAND_LONG to a vehicle that is ready: on the ground, disarmed,
and where it is another one in flight (a rover: armed). Commands that are not listed are
unsupported, as the last ones are here."""
_MODES_TEXT: Final = "The autopilot's name of each mode, and `custom_mode` in the heartbeat."
_TELEMETRY_TEXT: Final = """\
Sent unasked at a rate; or in a group whose rate is a parameter of that name, set by
REQUEST_DATA_STREAM too; or when asked for by SET_MESSAGE_INTERVAL or REQUEST_MESSAGE."""
_REQUESTS_TEXT: Final = """\
The result of REQUEST_MESSAGE (MAV_CMD 512) for what ground stations ask at the start, besides
telemetry; none is left without an answer."""
_ITEMS_TEXT: Final = """\
MAV_MISSION_RESULT of an item, in the frame that suits it. PX4 takes orders in the frame MISSION
only. Those that are accepted and concern cameras, gimbals or servos, and CONDITION_DELAY, are
passed over in flight; spline waypoints are flown straight."""
