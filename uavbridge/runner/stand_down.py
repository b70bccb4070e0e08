"""After a mission: autopilots that are not ours get their own safety nets back."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from uavbridge.clock import Clock, to_us
from uavbridge.runner.ticks import CONTROL_US
from uavbridge.vehicle.api import Done, Refused, RestoreNet, Vehicle

PATIENCE_S = 10.0  # mission time
_KEPT = "keeps the safety net that the mission gave it"


def stand_down(
    vehicles: Mapping[int, Vehicle], clock: Clock, tell: Callable[[str], None]
) -> tuple[int, ...]:
    """Put the nets back where motors are off; who is still armed keeps the mission's.

    Args:
        vehicles: by agent.
        clock: the mission's.
        tell: is told of every vehicle whose net was not put back.

    Returns:
        The agents of those.
    """
    t_us = clock.now_us()
    kept = {}
    for agent, vehicle in vehicles.items():
        if vehicle.state.armed:
            kept[agent] = f"is armed and {_KEPT}"
        else:
            vehicle.do(RestoreNet(), t_us)
    waiting = {agent: vehicle for agent, vehicle in vehicles.items() if agent not in kept}
    end_us = t_us + to_us(PATIENCE_S)
    while waiting and t_us < end_us:
        t_us += CONTROL_US
        clock.wait_until(t_us)
        for agent, vehicle in list(waiting.items()):
            for event in vehicle.advance(t_us):
                if isinstance(event, Done | Refused) and isinstance(event.command, RestoreNet):
                    del waiting[agent]
                    if isinstance(event, Refused):
                        kept[agent] = f"{_KEPT}: {event.reason}"
    kept |= {agent: f"{_KEPT}: no answer" for agent in waiting}
    for agent, why in kept.items():
        tell(f"agent {agent}: {why}")
    return tuple(sorted(kept))
