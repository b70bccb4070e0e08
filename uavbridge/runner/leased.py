"""Ids and ports of a mission's own vehicles, kept from the other simulators of the machine."""

from __future__ import annotations

import logging
from collections.abc import Collection
from types import TracebackType
from typing import Self

from sim_vehicles.leases import Leases, lease_systems, port_name
from sim_vehicles.ports import ServerError
from uavbridge.errors import LinkError

_log = logging.getLogger(__name__)


class Leased:
    """What simulated vehicles have for themselves as long as this is open.

    Args:
        agents: whose vehicles are simulated.
        leases: hold what was taken; None: new ones.

    Attributes:
        systems: system id of each; its agent's number where nobody else here has it.
    """

    def __init__(self, agents: Collection[int], leases: Leases | None = None) -> None:
        self._leases = leases or Leases()
        self.systems = lease_systems(agents, self._leases)

    def keep(self, port: int) -> int:
        """The port, which we listen on: no other simulator is to send there.

        Raises:
            LinkError: one does already.
        """
        name = port_name(port)
        try:
            ours = self._leases.take([name])
        except ServerError as fault:  # no folder for leases: fly without
            _log.debug("UDP port %d is not leased: %s", port, fault)
            return port
        if not ours:
            who = self._leases.holder(name)
            raise LinkError(f"UDP port {port} is another simulator's ({who})")
        return port

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._leases.close()
