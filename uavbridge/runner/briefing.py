"""What agents of other processes are told before they fly: mission, vehicles, the time.

The launcher answers ``world/briefing``. Whoever comes, in whatever order, asks until there is
an answer, and finds mission time by the answer that came back soonest.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

from msgspec import DecodeError, Struct
from msgspec.json import Decoder, Encoder

from uavbridge.bus import keys
from uavbridge.bus.api import Bus
from uavbridge.bus.text import read
from uavbridge.clock import pause, wall_date, wall_s
from uavbridge.errors import BusError

ASK_S = 0.2  # between two questions
SAMPLES = 8  # answers of which the quickest tells the time
_ANSWER_S = 1.0


class Briefing(Struct, frozen=True):
    """JSON on the bus."""

    mission: str  # the mission file as flown, without the targets
    vehicles: dict[str, str]  # where each simulated vehicle is found, by agent
    t_us: int | None  # mission time now; None: it has not begun
    speed: float
    date_us: int  # the launcher's date, Unix time


_ENCODER = Encoder()
_DECODER = Decoder(Briefing)


class Brief:
    """Answers for the launcher.

    Args:
        bus: the launcher's session.
        mission: TOML text, without the targets.
        vehicles: where each simulated vehicle is found, by agent.
        speed: mission seconds per second.
    """

    def __init__(self, bus: Bus, mission: str, vehicles: Mapping[int, str], speed: float) -> None:
        self._mission = mission
        self._vehicles = {str(agent): url for agent, url in vehicles.items()}
        self._speed = speed
        self._now_us: Callable[[], int] | None = None
        bus.serve(keys.BRIEFING, lambda _key: self._answer())

    def begin(self, now_us: Callable[[], int]) -> None:
        """Mission time has begun; ``now_us`` tells it, from any thread."""
        self._now_us = now_us

    def _answer(self) -> bytes:
        now_us = self._now_us
        return _ENCODER.encode(
            Briefing(
                self._mission,
                self._vehicles,
                None if now_us is None else now_us(),
                self._speed,
                round(wall_date().timestamp() * 1e6),
            )
        )


@dataclass(frozen=True, slots=True)
class Agreement:
    """What an agent's process and the launcher agree on.

    Attributes:
        epoch_ns: monotonic time (ns) of mission start on this machine.
        error_s: wall time by which it may be off.
        date_offset_s: this machine's date less the launcher's.
    """

    epoch_ns: int
    error_s: float
    date_offset_s: float


def ask(bus: Bus) -> Briefing | None:
    """One question; None: nobody answers."""
    for sample in bus.query(keys.BRIEFING, timeout_s=_ANSWER_S):
        try:
            return read(_DECODER, sample.data)
        except DecodeError:
            continue
    return None


def wait_for(
    bus: Bus,
    wanted: Callable[[Briefing], bool],
    *,
    wait_s: float,
    meanwhile: Callable[[], bool] = lambda: False,
) -> Briefing:
    """Ask until the answer is as wanted.

    Args:
        bus: a session of the mission.
        wanted: is it?
        wait_s: how long to ask.
        meanwhile: called between questions; True gives up.

    Raises:
        BusError: no such answer came.
    """
    until_s = wall_s() + wait_s
    while True:
        briefing = ask(bus)
        if briefing is not None and wanted(briefing):
            return briefing
        if meanwhile() or wall_s() > until_s:
            what = "no launcher answers" if briefing is None else "the mission does not begin"
            raise BusError(f"{what} within {wait_s:g} s (is uavbridge launch running there?)")
        pause(ASK_S)


def agree(bus: Bus, *, until: Callable[[], bool] = lambda: False) -> Agreement:
    """Mission time, from the launcher's answers.

    Args:
        bus: a session of the mission.
        until: asked between questions; True: no more of them.

    Raises:
        BusError: nobody answers any more.
    """
    best: Agreement | None = None
    for _ in range(SAMPLES):
        if until():
            break
        asked_s = wall_s()
        briefing = ask(bus)
        answered_s = wall_s()
        if briefing is None or briefing.t_us is None:
            continue
        error_s = (answered_s - asked_s) / 2
        if best is None or error_s < best.error_s:
            middle_s = asked_s + error_s
            epoch_ns = round((middle_s - briefing.t_us / briefing.speed / 1e6) * 1e9)
            date_s = wall_date().timestamp() - (wall_s() - middle_s)
            best = Agreement(epoch_ns, error_s, date_s - briefing.date_us / 1e6)
    if best is None:
        raise BusError("the launcher tells no mission time any more")
    return best
