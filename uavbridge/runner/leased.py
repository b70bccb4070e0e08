"""What a mission has for itself on this machine: its vehicles' ids and ports, its name on a bus."""

from __future__ import annotations

import logging
from collections.abc import Collection
from types import TracebackType
from typing import Self
from zlib import crc32

from sim_vehicles.leases import Leases, lease_systems, port_name
from sim_vehicles.ports import ServerError
from uavbridge.errors import BusError, LinkError

_log = logging.getLogger(__name__)


class Leased:
    """What simulated vehicles have for themselves as long as this is open.

    Args:
        agents: whose vehicles are simulated.
        bus: endpoint of a router that others may use too, and the mission's name; None: it has
            a router of its own.
        leases: hold what was taken; None: new ones.

    Raises:
        BusError: a mission of that name flies at that router already.

    Attributes:
        systems: system id of each; its agent's number where nobody else here has it.
    """

    def __init__(
        self,
        agents: Collection[int],
        bus: tuple[str, str] | None = None,
        leases: Leases | None = None,
    ) -> None:
        self._leases = leases or Leases()
        if bus is not None:
            endpoint, mission = bus
            who = self._taken(f"bus-{crc32(f'{endpoint} {mission}'.encode()):08x}")
            if who is not None:
                raise BusError(
                    f"bus.router: a mission {mission} flies at {endpoint} already ({who}); "
                    "give this one another name"
                )
        self.systems = lease_systems(agents, self._leases)

    def keep(self, port: int) -> int:
        """The port, which we listen on: no other simulator is to send there.

        Raises:
            LinkError: one does already.
        """
        who = self._taken(port_name(port))
        if who is not None:
            raise LinkError(f"UDP port {port} is another simulator's ({who})")
        return port

    def _taken(self, name: str) -> str | None:
        """Who has a name; None: we have it from now on."""
        try:
            return None if self._leases.take([name]) else self._leases.holder(name)
        except ServerError as fault:  # no folder for leases: fly without
            _log.debug("%s is not leased: %s", name, fault)
            return None

    def close(self) -> None:
        """Let go of everything."""
        self._leases.close()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()
