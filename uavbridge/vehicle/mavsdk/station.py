"""The one MAVSDK instance of a process, joined to our links by raw bytes.

MAVSDK binds no port here: what our links receive is handed to it, and what it sends is handed
to the link of the system that it is for. So a port in use, two sources of one system id, a
recording and signatures are what they are with the other driver, and there is one instance
however many vehicles there are (from about twenty on they corrupt the heap).
"""

from __future__ import annotations

import logging
import threading
from collections import deque
from typing import Any, Final

from sim_vehicles.codec import Counts, decode
from uavbridge.errors import ConfigError, VehicleError
from uavbridge.mavlink.identity import COMPONENT, SYSTEM
from uavbridge.mavlink.link import Link

_log = logging.getLogger(__name__)
_SETPOINTS: Final = frozenset({"SET_POSITION_TARGET_LOCAL_NED", "SET_POSITION_TARGET_GLOBAL_INT"})


class Station:
    """MAVSDK as a ground station of ours, shared by all vehicles of this process."""

    def __init__(self) -> None:
        sdk = import_mavsdk()
        from mavsdk.logging import log_subscribe

        log_subscribe(_logged)  # else it writes on standard output
        configuration = sdk.Configuration.create_manual(SYSTEM, COMPONENT, True)
        self._mavsdk = sdk.Mavsdk(configuration)
        self._out: deque[bytes] = deque()
        self._links: dict[int, Link] = {}
        self._muted: set[int] = set()
        self._mavsdk.subscribe_raw_bytes_to_be_sent(self._out.append)
        self._mavsdk.add_any_connection("raw://")

    def join(self, system: int, link: Link) -> None:
        """Speak to a system over a link. Raises VehicleError if it has one already."""
        if system in self._links:
            raise VehicleError(f"system {system} is driven by MAVSDK already")
        self._links[system] = link
        self._muted.add(system)

    def leave(self, system: int) -> None:
        """Speak to it no more."""
        self._links.pop(system, None)
        self._muted.discard(system)

    def mute(self, system: int, muted: bool) -> None:
        """Whether the setpoints that MAVSDK repeats on and on are held back."""
        (self._muted.add if muted else self._muted.discard)(system)

    def system(self, number: int) -> Any:
        """MAVSDK's system with an id; None while it has not heard it."""
        for found in self._mavsdk.get_systems():
            if found.get_system_id() == number and found.has_autopilot():
                return found
        return None

    def exchange(self, link: Link) -> bool:
        """Hand over what a link received, and send what waits; True: something was received."""
        datagrams = link.receive()
        for datagram in datagrams:
            self._mavsdk.pass_received_raw_bytes(datagram)
        while self._out:
            self._send(self._out.popleft())
        return bool(datagrams)

    def _send(self, data: bytes) -> None:
        for packet in decode(data, Counts()):
            target = getattr(packet.message, "target_system", 0)
            if packet.message.msgname in _SETPOINTS and target in self._muted:
                continue
            for system, link in self._links.items():
                if target in (0, system):
                    link.send(packet.raw)

    def close(self) -> None:
        """End MAVSDK's threads."""
        self._links.clear()
        self._mavsdk.destroy()


class _Shared:
    """The station of this process, while anybody needs it."""

    def __init__(self) -> None:
        self._station: Station | None = None
        self._users = 0
        self._lock = threading.Lock()

    def take(self) -> Station:
        with self._lock:
            if self._station is None:
                self._station = Station()
            self._users += 1
            return self._station

    def give_back(self) -> None:
        with self._lock:
            self._users -= 1
            if not self._users and self._station is not None:
                self._station.close()
                self._station = None


SHARED: Final = _Shared()


def import_mavsdk() -> Any:
    """The package. Raises ConfigError where it is not installed, or is an older one."""
    try:
        import mavsdk
    except ImportError:
        raise ConfigError(
            "mavlink.driver: mavsdk is not installed; pip install 'uavbridge[mavsdk]'"
        ) from None
    if not hasattr(mavsdk, "Configuration"):
        raise ConfigError("mavlink.driver: mavsdk is older than 4; pip install 'mavsdk>=4.1'")
    return mavsdk


def _logged(level: Any, message: str, _file: str | None, _line: int) -> bool:
    """MAVSDK's log goes to ours, at debug: what matters reaches us as events."""
    _log.debug("mavsdk %s: %s", getattr(level, "name", level), message)
    return True
