"""Place agents in a process of their own: ``uavbridge agent --place``.

They follow mission time by the true positions and the reports that the bus brings. Which flight
of the mission it is, the *run*, they ask the launcher: a flight that goes on (``launch --resume``)
is the same run, any other of the same name begins with maps that nobody has marked yet.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence
from contextlib import ExitStack, suppress
from pathlib import Path

from msgspec import DecodeError

from uavbridge.agent.report import decode as decode_report
from uavbridge.bus import keys
from uavbridge.bus.api import Bus
from uavbridge.bus.messages import decode_truth
from uavbridge.bus.security import Identity
from uavbridge.bus.zenoh_bus import ZenohBus
from uavbridge.clock import SECOND_US, pause, wall_s
from uavbridge.config import Mission
from uavbridge.place.host import PlaceHost
from uavbridge.place.store import Store
from uavbridge.runner.places import places_of
from uavbridge.runner.ticks import CONTROL_US

BEHIND_US = 60 * SECOND_US  # so much later they do not make up for what they have missed
LOOK_S = 0.02
ASK_S = 1.0  # wall time between two questions for the run
MOST_DIGITS = 20  # of a run's number


def tell_run(bus: Bus, run: int) -> None:
    """Answer place agents that ask which run of the mission it is."""
    said = str(run).encode()
    bus.serve(keys.RUN, lambda _key: said)


def keep_alone(
    mission: Mission,
    places: Sequence[int],
    *,
    router: str,
    store: Path | None,
    identity: Identity | None,
    wait_s: float,
    stop: Callable[[], bool],
    tell: Callable[[str], None],
) -> None:
    """Keep the maps of one flight of the mission after another, until told to stop.

    Args:
        mission: as the launcher flies it.
        places: their ids.
        router: zenoh endpoint.
        store: folder for their tiles, from which a flight that is under way is gone on with;
            None: they forget.
        identity: of this session.
        wait_s: for the router.
        stop: asked again and again.
        tell: is told what people need to know.

    Raises:
        BusError: no router.
        ConfigError: the store cannot be written to.
    """
    kept = None if store is None else Store(store)
    with ExitStack() as stack:

        def session() -> ZenohBus:
            return ZenohBus(router, mission.name, wait_s=wait_s, identity=identity)

        heard = _Heard(stack.enter_context(session()))
        tell(f"place agents {', '.join(map(str, places))}: router {router}")
        flight = stack.enter_context(ExitStack())
        keepers: PlaceHost | None = None
        done_us = -1
        while not stop():
            if heard.poll() and heard.another_run():
                flight.close()
                if kept is not None:
                    kept.run = heard.run
                bus = flight.enter_context(session())
                keepers = places_of(mission, bus, places, {} if kept is None else kept)
                done_us = -1
            now_us = heard.now_us // CONTROL_US * CONTROL_US
            late = done_us < 0 or now_us - done_us > BEHIND_US
            begins_us = now_us if late else done_us + CONTROL_US
            for t_us in range(begins_us, now_us + 1, CONTROL_US) if keepers else ():
                assert keepers is not None
                keepers.step(t_us)
                done_us = t_us
            pause(LOOK_S)


class _Heard:
    """Mission time and run, as the bus tells them."""

    def __init__(self, bus: Bus) -> None:
        self.run = 0
        self.now_us = 0
        self._bus = bus
        self._mailboxes = bus.subscribe(keys.TRUTH), bus.subscribe("state/*")
        self._rejects: Counter[str] = Counter()
        self._ask_s = 0.0

    def poll(self) -> bool:
        """Listen; whether anything was said of the time."""
        truths, states = (mailbox.drain() for mailbox in self._mailboxes)
        told = [truth.t_us for one in truths if (truth := decode_truth(one.data, self._rejects))]
        for sample in states:
            with suppress(DecodeError):
                told.append(decode_report(sample.data).t_us)
        self.now_us = max([self.now_us, *told])
        return bool(told)

    def another_run(self) -> bool:
        """Whether another run than before flies now."""
        if wall_s() < self._ask_s:
            return False
        answers = self._bus.query(keys.RUN)
        self._ask_s = wall_s() + ASK_S
        told = next((int(one.data) for one in answers if _is_run(one.data)), self.run)
        if told == self.run:
            return False
        self.run, self.now_us = told, 0
        return True


def _is_run(data: bytes) -> bool:
    return data.isdigit() and len(data) <= MOST_DIGITS
