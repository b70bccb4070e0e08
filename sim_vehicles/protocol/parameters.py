"""The parameter protocol: read, list, set, each answered with PARAM_VALUE."""

from __future__ import annotations

from typing import Final

from sim_vehicles.codec import Packet
from sim_vehicles.params import Type
from sim_vehicles.protocol import requests
from sim_vehicles.protocol.endpoint import Endpoint

_PER_TICK: Final = 10  # of a list, so that it does not come in one burst
_NO_INDEX: Final = 0xFFFF
_WARNING: Final = 4
_INFO: Final = 6


def on_read(endpoint: Endpoint, packet: Packet) -> None:
    """PARAM_REQUEST_READ by index or name; of unknown ones there is no answer, as by PX4."""
    message = packet.message
    parameters = endpoint.pilot.parameters
    if message.param_index >= 0:
        if message.param_index < len(parameters):
            _send(endpoint, message.param_index)
        return
    row = parameters.row(message.param_id)
    if row is not None:
        _send(endpoint, row)


def on_list(endpoint: Endpoint, packet: Packet) -> None:
    """PARAM_REQUEST_LIST: all of them, a few at a time."""
    for text in endpoint.services.flavour.greeting:
        endpoint.say(_INFO, text)
    endpoint.next_parameter = 0
    endpoint.busy = True


def go_on(endpoint: Endpoint) -> bool:
    """Send the next few of a list; whether there are more."""
    first = endpoint.next_parameter
    if first is None:
        return False
    last = min(first + _PER_TICK, len(endpoint.pilot.parameters))
    for row in range(first, last):
        _send(endpoint, row)
    endpoint.next_parameter = last if last < len(endpoint.pilot.parameters) else None
    return endpoint.next_parameter is not None


def on_set(endpoint: Endpoint, packet: Packet) -> None:
    """PARAM_SET: answered with the value it has then, changed or not."""
    message = packet.message
    parameters = endpoint.pilot.parameters
    row = parameters.row(message.param_id)
    if row is None:
        return
    parameter = parameters.table[row]
    flavour = endpoint.services.flavour
    if message.param_type == parameter.type or not flavour.answers.strict_types:
        value = flavour.decoded(parameter.type, message.param_value)
        try:
            parameters.set(endpoint.index, parameter.name, value)
            for stream, (name, _) in flavour.data_streams.items():
                if name == parameter.name:
                    requests.set_group(endpoint, stream)
        except ValueError as error:
            endpoint.say(_WARNING, str(error))
    else:
        endpoint.say(_WARNING, f"parameter {parameter.name} is {Type(parameter.type).name}")
    _send(endpoint, row, index=_NO_INDEX)


def _send(endpoint: Endpoint, row: int, index: int | None = None) -> None:
    parameters = endpoint.pilot.parameters
    parameter = parameters.table[row]
    value = parameters.get(endpoint.index, parameter.name)
    endpoint.send(
        "PARAM_VALUE",
        param_id=parameter.name,
        param_value=endpoint.services.flavour.encoded(parameter.type, value),
        param_type=int(parameter.type),
        param_count=len(parameters),
        param_index=row if index is None else index,
    )
