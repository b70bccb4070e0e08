"""The simulation's process, from outside (``Simulation``) and from inside (``main``).

The child is told on standard input: the mission with its targets, the UDP port of
each agent's vehicle, and the router. It answers ``ready`` with the ports that its
vehicles speak from, gets the moment of mission start, and then how far simulated time
may go, so that it stays with the agents where the machine is too slow. It ends when its
standard input closes, whatever became of its parent; but where agents have processes of
their own, and nobody said goodbye, only when no vehicle is armed any more.
"""

from __future__ import annotations

import asyncio
import logging
import os
import subprocess
import sys
import threading
from collections import Counter
from collections.abc import Mapping
from contextlib import suppress
from math import inf
from types import MappingProxyType, TracebackType
from typing import BinaryIO, Self

import msgspec
from msgspec import Struct

from sim_vehicles.fleet import Fleet
from sim_vehicles.server import serve
from sim_vehicles.udp import UdpPorts
from uavbridge.bus import keys
from uavbridge.bus.api import Bus
from uavbridge.bus.messages import decode_truth
from uavbridge.bus.security import LAUNCHER
from uavbridge.bus.zenoh_bus import ZenohBus
from uavbridge.clock import SECOND_US, PacedClock, wall_s
from uavbridge.config import Mission
from uavbridge.errors import UavbridgeError
from uavbridge.runner import assemble
from uavbridge.runner.child import end, spawn
from uavbridge.runner.ticks import CONTROL_US
from uavbridge.runner.transponders import Transponders
from uavbridge.runner.world import SimulatedWorld, world_of

START_IN_S = 0.1  # from the word to mission start
READY = "ready"
GOODBYE = b"end\n"
# Wall time without a word of a parent that stands still, after which it goes on; longer than the
# patience of ``LedClock``, as where the bus is away all wait for each other so long; but hardly.
PATIENCE_S = 2.1
IDLE_US = 10 * SECOND_US  # without a parent it ends when no vehicle was armed for so long


class Setup(Struct, frozen=True):
    """What the child is told first."""

    mission: Mission
    ports: dict[int, int]  # agent -> UDP port its vehicle speaks to; 0: it waits to be spoken to
    router: str
    systems: dict[int, int] = {}  # agent -> system id, where it is not the agent's number
    lingers: bool = False  # it outlives its parent until the vehicles are down


class Simulation:
    """The child process: vehicles, targets, sensors.

    Args:
        mission: with targets.
        ports: UDP port on loopback for the vehicle of each simulated agent; 0: the vehicle
            waits to be spoken to, at ``simulator.host``; none: no child.
        router: zenoh endpoint for readings and true positions.
        systems: system ids of those that have others than their agents' numbers.
        lingers: without a goodbye it ends only when no vehicle is armed any more.
    """

    def __init__(
        self,
        mission: Mission,
        ports: dict[int, int],
        router: str,
        *,
        systems: Mapping[int, int] = MappingProxyType({}),
        lingers: bool = False,
    ) -> None:
        self._speed = mission.speed
        self._agents = sorted(ports)
        self._process: subprocess.Popen[bytes] | None = None
        if not ports:
            return
        self._process = spawn(["uavbridge.runner.simulation"])
        setup = msgspec.msgpack.encode(Setup(mission, ports, router, dict(systems), lingers))
        self._say(b"%d\n" % len(setup) + setup)

    def ready(self) -> dict[int, int]:
        """Wait for the child; the port that each agent's vehicle speaks from.

        Raises:
            UavbridgeError: the simulation could not start.
        """
        if self._process is None:
            return {}
        assert self._process.stdout is not None
        answer = self._process.stdout.readline().decode().strip()
        if not answer.startswith(READY):
            why = f": {answer}" if answer else ""
            raise UavbridgeError(f"the simulation could not start{why}")
        ports = map(int, answer.removeprefix(READY).split())
        return dict(zip(self._agents, ports, strict=True))

    def start(self, in_s: float = START_IN_S) -> PacedClock:
        """Let mission time begin, once the child is ready; the clock both share."""
        if self._process is None:
            return PacedClock(self._speed)
        epoch_ns = PacedClock(self._speed).epoch_ns + int(in_s * 1e9)
        self._say(b"%d\n" % epoch_ns)
        assert self._process.stdin is not None
        os.set_blocking(self._process.stdin.fileno(), False)
        return PacedClock(self._speed, epoch_ns=epoch_ns)

    def allow(self, t_us: int) -> None:
        """Let simulated time go on to ``t_us``: it must not run ahead of the agents."""
        if self._process is None:
            return
        assert self._process.stdin is not None
        with suppress(BlockingIOError, BrokenPipeError):  # it stands still; it is dead
            os.write(self._process.stdin.fileno(), b"%d\n" % t_us)

    def check(self) -> None:
        """Raises UavbridgeError when the child has died."""
        if self._process is not None and self._process.poll() is not None:
            raise UavbridgeError(f"the simulation ended (status {self._process.returncode})")

    def close(self) -> None:
        """End the child."""
        if self._process is None:
            return
        end(self._process, GOODBYE)
        self._process = None

    def _say(self, data: bytes) -> None:
        assert self._process is not None
        assert self._process.stdin is not None
        try:
            self._process.stdin.write(data)
            self._process.stdin.flush()
        except BrokenPipeError:
            raise UavbridgeError("the simulation could not start") from None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


class Reached:
    """How far the simulation is, by the true positions that it publishes."""

    def __init__(self, bus: Bus) -> None:
        self._mailbox = bus.subscribe(keys.TRUTH)
        self._rejects: Counter[str] = Counter()
        self._t_us = 0

    def __call__(self) -> int:
        for sample in self._mailbox.drain():
            truth = decode_truth(sample.data, self._rejects)
            if truth is not None:
                self._t_us = truth.t_us
        return self._t_us


def main() -> int:
    """The child: serve the vehicles until standard input closes."""
    try:
        _serve_parent(sys.stdin.buffer)
    except UavbridgeError as error:
        _answer(str(error))
        return error.exit_status
    return 0


def _answer(text: str) -> None:
    with suppress(BrokenPipeError):  # nobody is there to be told
        sys.stdout.write(f"{text}\n")
        sys.stdout.flush()


def _serve_parent(told: BinaryIO) -> None:
    setup = msgspec.msgpack.decode(told.read(int(told.readline())), type=Setup)
    agents = tuple(sorted(setup.ports))
    fleet = assemble.fleet_of(setup.mission, agents, setup.systems)
    identity = assemble.identity_of(setup.mission, LAUNCHER)
    with ZenohBus(setup.router, setup.mission.name, identity=identity) as bus:
        world = world_of(setup.mission, fleet, agents, bus)
        tiling = assemble.beacon_tiling(setup.mission)
        devices = Transponders(agents, bus, tiling) if setup.lingers else None
        ports = UdpPorts(
            setup.mission.simulator.host, [setup.ports[agent] or None for agent in agents]
        )
        _answer(" ".join([READY, *map(str, ports.local_ports)]))
        epoch = told.readline()
        if epoch:
            asyncio.run(_serve(fleet, world, devices, ports, setup, int(epoch)))


class _Orphan:
    """Whether vehicles without a parent still need their simulation."""

    def __init__(self, fleet: Fleet) -> None:
        self._fleet = fleet
        self._armed_us = fleet.now_us

    def idle(self, t_us: int) -> bool:
        if self._fleet.truth().armed.any():
            self._armed_us = t_us
        return t_us - self._armed_us > IDLE_US


class _Led:
    """How far simulated time may go.

    Args:
        fleet: the vehicles.
        waits: for as long as the parent says nothing; else agents of other processes do not lack
            their vehicles because it stands still: they go on until it has caught up.
    """

    def __init__(self, fleet: Fleet, *, waits: bool) -> None:
        self._fleet, self._waits = fleet, waits
        self._until_us: float = 0
        self._told_s = wall_s()
        self._alone = False

    def allow(self, t_us: float) -> None:
        """The parent's word."""
        self._until_us, self._told_s = t_us, wall_s()

    def allowed_us(self) -> float:
        if not self._waits and wall_s() - self._told_s > PATIENCE_S:
            self._alone = True
        elif self._until_us > self._fleet.now_us:
            self._alone = False
        return inf if self._alone else self._until_us


async def _serve(
    fleet: Fleet,
    world: SimulatedWorld,
    devices: Transponders | None,
    ports: UdpPorts,
    setup: Setup,
    epoch_ns: int,
) -> None:
    loop, stop = asyncio.get_running_loop(), asyncio.Event()
    led = _Led(fleet, waits=not setup.lingers)
    orphan: _Orphan | None = None

    def lose_parent(goodbye: bool) -> None:
        nonlocal orphan
        if goodbye or not setup.lingers:
            stop.set()
        else:
            led.allow(inf)
            orphan = _Orphan(fleet)

    def follow_parent() -> None:
        line = b""
        for line in sys.stdin.buffer:
            if line != GOODBYE:
                led.allow(int(line))
        loop.call_soon_threadsafe(lose_parent, line == GOODBYE)

    def look(_fleet: Fleet, t_us: int) -> None:
        if t_us % CONTROL_US == 0:
            world.step(t_us)
            if devices is not None:
                states = fleet.states
                devices.step(t_us, states.position, states.velocity, ~states.on_ground)
            if orphan is not None and orphan.idle(t_us):
                stop.set()

    threading.Thread(target=follow_parent, daemon=True).start()
    # What is lost is lost: agents and vehicles wait for each other, and the view shows the
    # speed that comes of it.
    logging.getLogger("sim_vehicles").setLevel(logging.ERROR)
    await serve(
        fleet,
        ports,
        speed=setup.mission.speed,
        epoch_ns=epoch_ns,
        slips=True,
        allowed_us=led.allowed_us,
        on_step=look,
        stop=stop,
    )


if __name__ == "__main__":
    sys.exit(main())
