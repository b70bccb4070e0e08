"""Tell agents of a flying mission what to do, and wait for their answers."""

from __future__ import annotations

from dataclasses import dataclass

import msgspec

from uavbridge.agent.orders import Ack, Order, Verb, decode_ack, encode
from uavbridge.bus import keys
from uavbridge.bus.api import Bus
from uavbridge.bus.wire import Vector
from uavbridge.clock import pause, wall_s

POLL_S = 0.01


@dataclass(frozen=True, slots=True)
class Reply:
    """What became of an order at one agent."""

    agent: int
    ok: bool
    reason: str
    took_s: float  # wall time from the order to the answer


def send_order(
    bus: Bus,
    verb: Verb,
    *,
    agents: tuple[int, ...],
    everyone: bool,
    name: str,
    position: Vector | None = None,
    timeout_s: float = 5.0,
) -> list[Reply]:
    """Give an order and collect the answers.

    Args:
        bus: the mission's.
        verb: what to do.
        agents: who is to answer.
        everyone: send one order to all, instead of one to each.
        name: of this order, different from every other's.
        position: of a goto, ENU m.
        timeout_s: wall time to wait for the slowest.

    Returns:
        A reply for each of ``agents``, in their order; who does not answer is not ok.
    """
    answers = bus.subscribe(keys.ack("*"))
    data = encode(Order(verb, name, position))
    began_s = wall_s()
    for target in (keys.EVERYONE,) if everyone else agents:
        bus.publish(keys.cmd(target), data)
    found: dict[int, Reply] = {}
    while wall_s() < began_s + timeout_s and len(found) < len(agents):
        for sample in answers.drain():
            ack = _ack(sample.data)
            if ack is not None and ack.id == name:
                found[ack.agent] = Reply(ack.agent, ack.ok, ack.reason, wall_s() - began_s)
        pause(POLL_S)
    answers.close()
    silent = f"no answer in {timeout_s:g} s"
    return [found.get(agent, Reply(agent, False, silent, timeout_s)) for agent in agents]


def _ack(data: bytes) -> Ack | None:
    try:
        return decode_ack(data)
    except msgspec.DecodeError:
        return None
