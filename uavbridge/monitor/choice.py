"""What the keys of the terminal monitor do: choose an agent, give an order, answer a question."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from uavbridge.agent.orders import Verb

KEYS: dict[str, Verb] = {
    "p": Verb.PAUSE,
    "r": Verb.RESUME,
    "h": Verb.HOLD,
    "t": Verb.RETURN,
    "l": Verb.LAND,
    "a": Verb.ABORT,
}
DANGEROUS = frozenset({Verb.HOLD, Verb.RETURN, Verb.LAND, Verb.ABORT})
HELP = "p pause r resume h hold t return l land a abort ↑↓ choose q quit"

Send = Callable[[Verb, int | None], str]
"""Gives an order to one agent or to all; tells in a line what came of it."""


@dataclass(slots=True)
class Choice:
    """What the keys have chosen."""

    chosen: int | None = None  # agent; None: all
    asked: Verb | None = None  # waits for y
    said: str = ""  # what came of the last order
    done: bool = False


def moved(state: Choice, key: str, agents: list[int]) -> bool:
    """The keys of every screen, of recordings too: choose, quit. False: it was none of them."""
    if key in ("q", "\x03", "\x04"):
        state.done = True
    elif key in ("up", "down"):
        ring: list[int | None] = [None, *agents]
        at = ring.index(state.chosen) if state.chosen in ring else 0
        state.chosen = ring[(at + (1 if key == "down" else -1)) % len(ring)]
    else:
        return False
    return True


def press(state: Choice, key: str, agents: list[int], send: Send) -> None:
    """One key: choose, order, answer a question, quit."""
    if state.asked is not None:
        verb, state.asked = state.asked, None
        state.said = send(verb, state.chosen) if key in "yY" else f"{verb.value}: not sent"
    elif moved(state, key, agents):
        state.said = ""
    elif (order := KEYS.get(key)) is not None:
        if order in DANGEROUS:
            state.asked = order
        else:
            state.said = send(order, state.chosen)
