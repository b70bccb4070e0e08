"""Orders to one agent: which may be followed now, and their answers, now or by the vehicle."""

from __future__ import annotations

from uavbridge.agent.effects import Answer, Effect
from uavbridge.agent.orders import Ack, Order, Verb
from uavbridge.agent.phases import ORDERS, Phase
from uavbridge.vehicle.api import Command, Disarm, Follow, HoldPosition, LandHere

BY_VEHICLE = frozenset({Verb.HOLD, Verb.TAKEOVER, Verb.LAND, Verb.ABORT})
ASKED_BY: dict[type[Command], frozenset[Verb]] = {
    HoldPosition: frozenset({Verb.HOLD}),
    Follow: frozenset({Verb.TAKEOVER}),
    LandHere: frozenset({Verb.LAND, Verb.ABORT}),
    Disarm: frozenset({Verb.LAND, Verb.ABORT}),  # of a vehicle that drives
}


class Obeying:
    """What orders have asked for and what is owed for them.

    Attributes:
        effects: answers go there.
        handing: the vehicle is being left to its autopilot's hold.
        taking: and being taken back.
    """

    def __init__(self, agent: int) -> None:
        self.effects: list[Effect] = []
        self.handing = False
        self.taking = False
        self._agent = agent
        self._owed: Order | None = None  # its answer waits for the vehicle's

    def phase_after(self, order: Order, phase: Phase) -> Phase | None:
        """The phase that an order leads to; None when it is not obeyed in this one."""
        phases, after = ORDERS[order.verb]
        if phase not in phases:
            return None
        if order.verb is Verb.TAKEOVER:
            self.taking = True
            return phase  # it is ours only once the vehicle says so
        self.handing = order.verb is Verb.HOLD
        return after

    def answer(self, order: Order, refusal: str, t_us: int) -> None:
        """Answer an order, or keep its answer until the vehicle has given its own."""
        if not refusal and order.verb in BY_VEHICLE:
            self._owed = order
        elif order.id:
            verb = order.verb.value
            ack = Ack(order.id, self._agent, verb, not refusal, refusal, t_us)
            self.effects.append(Answer(ack))

    def settle(self, command: Command, refusal: str, t_us: int) -> None:
        """The vehicle has done, or refused, what an order asked of it."""
        owed = self._owed
        if owed is not None and owed.verb in ASKED_BY.get(type(command), frozenset()):
            self._owed = None
            if owed.id:
                ack = Ack(owed.id, self._agent, owed.verb.value, not refusal, refusal, t_us)
                self.effects.append(Answer(ack))
