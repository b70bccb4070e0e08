"""UDP multicast: vehicles and ground stations of one network hear each other."""

from __future__ import annotations

import logging
import socket
from contextlib import ExitStack

from uavbridge.errors import LinkError
from uavbridge.mavlink.peer import Address
from uavbridge.mavlink.udp import drain

logger = logging.getLogger(__name__)


class MulticastGate:
    """Listens to a group and sends to it, from a port of its own.

    Args:
        group: IPv4 address of the group.
        port: of the group.

    Raises:
        LinkError: the group cannot be joined.
    """

    def __init__(self, group: str, port: int) -> None:
        self._group: Address = (group, port)
        with ExitStack() as stack:
            self._in = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            self._out = stack.enter_context(socket.socket(socket.AF_INET, socket.SOCK_DGRAM))
            self._in.setblocking(False)
            self._out.setblocking(False)
            try:
                self._in.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
                self._in.bind(self._group)
                member = socket.inet_aton(group) + socket.inet_aton("0.0.0.0")
                self._in.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, member)
                self._out.bind(("", 0))
            except OSError as error:
                raise LinkError(f"multicast {group}:{port}: {error.strerror or error}") from error
            stack.pop_all()

    @property
    def port(self) -> int:
        return self._group[1]

    def receive(self) -> list[tuple[bytes, Address | None]]:
        own = self._out.getsockname()[1]
        return [(data, sender) for data, sender in drain(self._in) if sender[1] != own]

    def send(self, data: bytes, address: Address | None) -> bool:
        try:
            self._out.sendto(data, self._group)
        except OSError as error:
            logger.debug("not sent to %s:%d: %s", *self._group, error)
            return False
        return True

    def close(self) -> None:
        self._in.close()
        self._out.close()
