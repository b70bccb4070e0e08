"""Messages a client wants: asked for while they do not come by themselves.

Autopilots differ in what they stream unasked. What comes often enough is left
alone; for what does not, SET_MESSAGE_INTERVAL or REQUEST_MESSAGE is sent, at
first every round, then ever more seldom. No answer is awaited: the message
coming is the answer.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

from sim_vehicles.codec import mav
from uavbridge.mavlink.commands import Order

ROUND_S: Final = 2.0  # time between two looks at the rates


@dataclass(frozen=True, slots=True)
class Wish:
    """A message that should come ``rate_hz`` times a second."""

    name: str
    rate_hz: float

    @property
    def order(self) -> Order:
        """The command that asks for it."""
        msgid = float(getattr(mav, f"MAVLINK_MSG_ID_{self.name}"))
        interval_us = 1e6 / self.rate_hz
        return Order(mav.MAV_CMD_SET_MESSAGE_INTERVAL, (msgid, interval_us, 0, 0, 0, 0, 0))


STREAMS: Final = (
    Wish("LOCAL_POSITION_NED", 10.0),
    Wish("GLOBAL_POSITION_INT", 5.0),
    Wish("EXTENDED_SYS_STATE", 2.0),
    Wish("SYS_STATUS", 1.0),
)


def once(name: str) -> Order:
    """The command that asks for one message now."""
    msgid = float(getattr(mav, f"MAVLINK_MSG_ID_{name}"))
    return Order(mav.MAV_CMD_REQUEST_MESSAGE, (msgid, 0, 0, 0, 0, 0, 0))


class Wishes:
    """Watches the rates of what is wanted.

    Args:
        streams: what is wanted.
    """

    def __init__(self, streams: tuple[Wish, ...] = STREAMS) -> None:
        self._streams = streams
        self.heard: Final = dict.fromkeys((wish.name for wish in streams), 0)
        """Messages of each stream since the last round; the owner counts them up."""
        self._misses = dict.fromkeys(self.heard, 0)

    def round(self) -> list[Order]:
        """Call every ``ROUND_S``: what to ask for now."""
        orders = []
        for wish in self._streams:
            enough = self.heard[wish.name] >= wish.rate_hz * ROUND_S / 2
            self.heard[wish.name] = 0
            misses = self._misses[wish.name] = 0 if enough else self._misses[wish.name] + 1
            if misses and misses & (misses - 1) == 0:  # 1, 2, 4, 8 ...
                orders.append(wish.order)
        return orders
