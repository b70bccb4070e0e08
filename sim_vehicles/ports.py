"""Which vehicle has which system id, and which port its telemetry goes to."""

from __future__ import annotations

import socket
from dataclasses import dataclass
from typing import Final, TypeAlias

Address: TypeAlias = tuple[str, int]

BASE_PORT: Final = 14540  # where PX4's simulated vehicles send to
GROUND_STATION_PORT: Final = 14550  # never taken: ground stations listen there
EACH_UP_TO: Final = 10  # so many vehicles get a port each unasked
NETWORK: Final = 250  # vehicles that share one port: system ids have 8 bits


class ServerError(Exception):
    """A port or an address that can not be used; the message names it."""


@dataclass(frozen=True, slots=True)
class Seat:
    """One vehicle's place on the network."""

    system: int  # MAVLink system id
    port: int  # UDP: telemetry goes there; TCP: clients connect there


def seats(
    count: int, *, each: bool | None = None, base: int = BASE_PORT, start_system: int = 1
) -> tuple[Seat, ...]:
    """Ids and ports of ``count`` vehicles.

    System ids count up from ``start_system``. With one port each, vehicle i has ``base`` + i.
    With a shared port all have ``base``; past 250 vehicles (or system id 250) the ids start
    again and the next 250 have ``base`` + 1, and so on. 14550 is left out, unless ``base``
    asks for it.

    Args:
        count: vehicles.
        each: a port for each vehicle; None: up to ten vehicles.
        base: first port.
        start_system: system id of the first vehicle.

    Raises:
        ValueError: an id or a port out of range.
    """
    if not 1 <= start_system <= NETWORK:
        raise ValueError(f"the first system id must be 1..{NETWORK}, not {start_system}")
    if each is None:
        each = count <= EACH_UP_TO
    network = NETWORK - start_system + 1
    blocks = count if each else -(-count // network)
    taken = GROUND_STATION_PORT if base != GROUND_STATION_PORT else 0
    ports = [port for port in range(base, base + blocks + 1) if port != taken]
    if base < 1 or ports[blocks - 1] > 65535:
        raise ValueError(f"ports must be 1..65535, not {base}..{ports[blocks - 1]}")
    return tuple(
        Seat(start_system + i % network, ports[i if each else i // network]) for i in range(count)
    )


def resolve(host: str) -> str:
    """The IPv4 address of a host name.

    Raises:
        ServerError: there is no such host.
    """
    try:
        return socket.gethostbyname(host)
    except (OSError, UnicodeError) as error:
        raise ServerError(f"host {host}: {error}") from error
