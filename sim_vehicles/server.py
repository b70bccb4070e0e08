"""A fleet on the network, paced by the clock: one event loop for all vehicles."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Final, Protocol, TypeVar

from sim_vehicles.transport import Traffic, Transport

_log = logging.getLogger(__name__)
_SECOND_US: Final = 1_000_000
_SHORTEST_SLEEP_S: Final = 0.001
_LONGEST_SLEEP_S: Final = 0.1  # a stop is noticed within
_LATE_S: Final = 0.5  # behind the clock by so much: said once


class Served(Protocol):
    """What the server needs of a fleet; ``sim_vehicles.fleet.Fleet`` has it."""

    @property
    def now_us(self) -> int:
        """Simulated time."""
        ...

    def advance(self, until_us: int) -> None:
        """Simulate up to ``until_us``."""
        ...

    def receive(self, index: int, datagram: bytes) -> None:
        """Take what arrived for one vehicle."""
        ...

    def transmit(self) -> list[tuple[int, bytes]]:
        """What vehicles send since the last call: (index, datagram)."""
        ...


FleetT = TypeVar("FleetT", bound=Served)


@dataclass(frozen=True, slots=True)
class Report:
    """How it went."""

    simulated_s: float
    wall_s: float
    late: bool  # could not keep up with the clock at some time
    traffic: Traffic

    @property
    def rate(self) -> float:
        """Simulated seconds per wall second."""
        return self.simulated_s / self.wall_s if self.wall_s else 0.0


class Pace:
    """Simulated time as the wall clock has it.

    Args:
        wall_s: monotonic wall time now, seconds.
        speed: simulated seconds per wall second; inf: as fast as the machine can go.
        epoch_ns: monotonic time (ns) of simulated time 0; None: now.
        slips: where the machine can not keep up the epoch moves along; None: where it is
            not given.
    """

    def __init__(
        self, wall_s: float, speed: float, epoch_ns: int | None, *, slips: bool | None = None
    ) -> None:
        if not speed > 0:
            raise ValueError(f"speed must be positive, not {speed}")
        self.speed = speed
        self._epoch_s = wall_s if epoch_ns is None else epoch_ns / 1e9
        self._slips = epoch_ns is None if slips is None else slips

    def left_s(self, t_us: int, wall_s: float) -> float:
        """Wall seconds until simulated time ``t_us`` is due; below 0: overdue."""
        if self.speed == inf:
            return 0.0
        return self._epoch_s + t_us / _SECOND_US / self.speed - wall_s

    def slip(self, by_s: float) -> None:
        """Give up ``by_s`` wall seconds for lost, unless the epoch stands."""
        if self._slips:
            self._epoch_s += by_s


async def serve(
    fleet: FleetT,
    transport: Transport,
    *,
    speed: float = 1.0,
    epoch_ns: int | None = None,
    slips: bool | None = None,
    allowed_us: Callable[[], float] | None = None,
    duration_s: float = inf,
    period_s: float = 0.02,
    on_step: Callable[[FleetT, int], None] | None = None,
    stop: asyncio.Event | None = None,
) -> Report:
    """Fly ``fleet`` over ``transport`` until ``stop`` is set or ``duration_s`` is over.

    Closes the transport in the end. If the machine can not keep up, every step is still
    made and every frame sent, only later; a warning says so once.

    Args:
        fleet: the vehicles.
        transport: carries their datagrams.
        speed: simulated seconds per wall second; inf: as fast as the machine can go.
        epoch_ns: monotonic time (ns) of simulated time 0, shared with other processes;
            None: now.
        slips: give up time that is lost rather than hurry after it; None: unless
            ``epoch_ns`` is given.
        allowed_us: asks how far simulated time may go by now; it waits for others there.
        duration_s: simulated time to run for.
        period_s: simulated time between two steps.
        on_step: called after each step, when its frames are sent, with the fleet and its time.
        stop: ends it.
    """
    loop = asyncio.get_running_loop()
    exchange = _Exchange(fleet, transport)
    begin_s, begin_us = loop.time(), fleet.now_us
    pace = Pace(begin_s - begin_us / _SECOND_US / speed, speed, epoch_ns, slips=slips)
    period_us = round(period_s * _SECOND_US)
    end_us = inf if duration_s == inf else begin_us + round(duration_s * _SECOND_US)
    late = False
    try:
        await transport.start(loop, exchange.receive)
        while fleet.now_us < end_us and not (stop and stop.is_set()):
            until_us = fleet.now_us + period_us
            left_s = pace.left_s(until_us, loop.time())
            if left_s > 0:
                await asyncio.sleep(min(max(left_s, _SHORTEST_SLEEP_S), _LONGEST_SLEEP_S))
                continue
            if allowed_us is not None and until_us > allowed_us():
                await asyncio.sleep(_SHORTEST_SLEEP_S)
                continue
            fleet.advance(until_us)
            exchange.flush()
            if on_step is not None:
                on_step(fleet, until_us)
            if left_s < -_LATE_S:
                pace.slip(-left_s)
                if not late:
                    late = True
                    rate = (fleet.now_us - begin_us) / _SECOND_US / (loop.time() - begin_s)
                    _log.warning("can not keep up: x%.3g of x%g asked for", rate, speed)
            await asyncio.sleep(0)  # let what arrived in
    finally:
        exchange.close()
    return Report(
        simulated_s=(fleet.now_us - begin_us) / _SECOND_US,
        wall_s=loop.time() - begin_s,
        late=late,
        traffic=transport.traffic,
    )


class _Exchange:
    """Joins a fleet and a transport."""

    def __init__(self, fleet: Served, transport: Transport) -> None:
        self._fleet = fleet
        self._transport = transport
        self._waiting = False
        self._closed = False

    def receive(self, index: int, datagram: bytes) -> None:
        """Hand over what arrived; answers go out without waiting for the next step."""
        self._fleet.receive(index, datagram)
        if not self._waiting:
            self._waiting = True
            asyncio.get_running_loop().call_soon(self.flush)

    def flush(self) -> None:
        """Send what the vehicles have to say, while there is a transport."""
        self._waiting = False
        if self._closed:
            return
        send = self._transport.send
        for index, datagram in self._fleet.transmit():
            send(index, datagram)

    def close(self) -> None:
        """Let go of the transport; answers that wait for their turn are dropped."""
        self._closed = True
        self._transport.close()
