"""Which service takes which message."""

from __future__ import annotations

from typing import Final

from sim_vehicles.protocol import (
    attitudes,
    commands,
    link,
    missions,
    parameters,
    requests,
    setpoints,
)
from sim_vehicles.protocol.endpoint import Endpoint, Handlers

HANDLERS: Final[Handlers] = {
    "HEARTBEAT": link.on_heartbeat,
    "PING": link.on_ping,
    "TIMESYNC": link.on_timesync,
    "COMMAND_LONG": commands.on_command,
    "COMMAND_INT": commands.on_command,
    "SET_MODE": commands.on_set_mode,
    "FILE_TRANSFER_PROTOCOL": requests.on_file,
    "LOG_REQUEST_LIST": requests.on_log_list,
    "REQUEST_DATA_STREAM": requests.on_data_stream,
    "SET_ATTITUDE_TARGET": attitudes.on_attitude,
    "SET_POSITION_TARGET_LOCAL_NED": setpoints.on_local,
    "SET_POSITION_TARGET_GLOBAL_INT": setpoints.on_global,
    "PARAM_REQUEST_READ": parameters.on_read,
    "PARAM_REQUEST_LIST": parameters.on_list,
    "PARAM_SET": parameters.on_set,
    "MISSION_COUNT": missions.on_count,
    "MISSION_ITEM": missions.on_item,
    "MISSION_ITEM_INT": missions.on_item,
    "MISSION_REQUEST_LIST": missions.on_request_list,
    "MISSION_REQUEST": missions.on_request,
    "MISSION_REQUEST_INT": missions.on_request,
    "MISSION_ACK": missions.on_ack,
    "MISSION_CLEAR_ALL": missions.on_clear,
    "MISSION_SET_CURRENT": missions.on_set_current,
    "MISSION_REQUEST_PARTIAL_LIST": missions.on_partial,
    "MISSION_WRITE_PARTIAL_LIST": missions.on_partial,
}
"""Other messages are none of an autopilot's business here, and are passed over."""


def go_on(endpoint: Endpoint) -> None:
    """Run the timers of a busy endpoint; every tenth of a second or so."""
    listing = parameters.go_on(endpoint)
    uploading = missions.go_on(endpoint)
    endpoint.busy = listing or uploading
