"""One process for each agent: who comes as a second one, or wakes up as one, gives way."""

from __future__ import annotations

from collections.abc import Sequence

from uavbridge.bus import keys
from uavbridge.bus.zenoh_bus import ZenohBus
from uavbridge.clock import pause, wall_s
from uavbridge.errors import BusError

PATIENCE_S = 3.0  # wall time in which whoever died without a word is known to be gone
_LOOK_S = 0.05


def refuse_twins(bus: ZenohBus, mission: str, agents: Sequence[int]) -> None:
    """Before flying.

    Args:
        bus: this process's session, which has not said yet that the agents live.
        mission: its name.
        agents: those of this process.

    Raises:
        BusError: another process has some of the agents, and lives.
    """
    name, until_s = keys.prefix(mission).split("/")[1], wall_s() + PATIENCE_S
    while taken := sorted(set(agents).intersection(bus.missions().get(name, ()))):
        if wall_s() > until_s:
            whose = ", ".join(map(str, taken))
            raise BusError(f"agent {whose}: another process flies it already")
        pause(_LOOK_S)


def give_way(bus: ZenohBus, agents: Sequence[int], still_s: float) -> None:
    """In flight, after this process stood still.

    Args:
        bus: this process's session, on which all its agents answer for their maps.
        agents: those of this process.
        still_s: for how long.

    Raises:
        BusError: another process has taken over one of the agents meanwhile.
    """
    until_s = wall_s() + PATIENCE_S
    while not bus.connected and wall_s() < until_s:
        pause(_LOOK_S)
    for agent in agents:
        if bus.connected and len(bus.query(keys.state_cells(agent))) > 1:
            raise BusError(
                f"agent {agent}: this process stood still for {still_s:.0f} s, and another one "
                "flies it by now"
            )
