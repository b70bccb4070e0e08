"""The simulation's process, from outside (``Simulation``) and from inside (``main``).

The child is told on standard input: the mission with its targets, the UDP port of
each agent's vehicle, and the router. It answers ``ready``, gets the moment of
mission start, and then how far simulated time may go, so that it stays with the
agents where the machine is too slow. It runs until its standard input closes:
whatever happens to its parent, it ends.
"""

from __future__ import annotations

import asyncio
import logging
import os
import subprocess
import sys
import threading
from collections import Counter
from contextlib import suppress
from types import TracebackType
from typing import BinaryIO, Self

import msgspec
from msgspec import Struct

from sim_vehicles.fleet import Fleet
from sim_vehicles.server import serve
from sim_vehicles.udp import UdpPorts
from uavbridge.bus import keys
from uavbridge.bus.api import Bus
from uavbridge.bus.messages import decode_truth
from uavbridge.bus.zenoh_bus import ZenohBus
from uavbridge.clock import PacedClock
from uavbridge.config import Mission
from uavbridge.errors import UavbridgeError
from uavbridge.runner import assemble
from uavbridge.runner.control import CONTROL_US, LOOPBACK
from uavbridge.runner.world import SimulatedWorld, world_of

START_IN_S = 0.1  # from the word to mission start
READY = "ready"
PATIENCE_S = 5.0  # for a child that was told to end


class Setup(Struct, frozen=True):
    """What the child is told first."""

    mission: Mission
    ports: dict[int, int]  # agent -> UDP port its vehicle speaks to
    router: str


class Simulation:
    """The child process: vehicles, targets, sensors.

    Args:
        mission: with targets.
        ports: UDP port on loopback for the vehicle of each simulated agent; none: no child.
        router: zenoh endpoint for readings and true positions.
    """

    def __init__(self, mission: Mission, ports: dict[int, int], router: str) -> None:
        self._speed = mission.speed
        self._process: subprocess.Popen[bytes] | None = None
        if not ports:
            return
        self._process = subprocess.Popen(
            [sys.executable, "-m", "uavbridge.runner.simulation"],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            start_new_session=True,  # Ctrl-C is for the parent to act on
            env={**os.environ, "PYTHONPATH": _module_path(), "PYTHONSAFEPATH": "1"},
        )
        setup = msgspec.msgpack.encode(Setup(mission, ports, router))
        self._say(b"%d\n" % len(setup) + setup)

    def start(self) -> PacedClock:
        """Wait for the child to be ready and let mission time begin; the clock both share.

        Raises:
            UavbridgeError: the simulation could not start.
        """
        if self._process is None:
            return PacedClock(self._speed)
        assert self._process.stdout is not None
        answer = self._process.stdout.readline().decode().strip()
        if answer != READY:
            why = f": {answer}" if answer else ""
            raise UavbridgeError(f"the simulation could not start{why}")
        epoch_ns = PacedClock(self._speed).epoch_ns + int(START_IN_S * 1e9)
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
        assert self._process.stdin is not None
        assert self._process.stdout is not None
        with suppress(BrokenPipeError):  # it died; what is left to say does not matter
            self._process.stdin.close()
        try:
            self._process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()
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


def _module_path() -> str:
    """Where this process finds its modules: the child finds the same ones, wherever it starts."""
    return os.pathsep.join(path or os.getcwd() for path in sys.path)


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
    fleet = assemble.fleet_of(setup.mission, agents)
    with ZenohBus(setup.router, setup.mission.name) as bus:
        world = world_of(setup.mission, fleet, agents, bus)
        _answer(READY)
        epoch = told.readline()
        if epoch:
            asyncio.run(_serve(fleet, world, setup, int(epoch)))


async def _serve(fleet: Fleet, world: SimulatedWorld, setup: Setup, epoch_ns: int) -> None:
    loop, stop = asyncio.get_running_loop(), asyncio.Event()

    allowed_us = 0

    def follow_parent() -> None:
        nonlocal allowed_us
        for line in sys.stdin.buffer:
            allowed_us = int(line)
        loop.call_soon_threadsafe(stop.set)

    def look(_fleet: Fleet, t_us: int) -> None:
        if t_us % CONTROL_US == 0:
            world.step(t_us)

    threading.Thread(target=follow_parent, daemon=True).start()
    ports = UdpPorts(LOOPBACK, [setup.ports[agent] for agent in sorted(setup.ports)])
    # What is lost is lost: agents and vehicles wait for each other, and the view shows the
    # speed that comes of it.
    logging.getLogger("sim_vehicles").setLevel(logging.ERROR)
    await serve(
        fleet,
        ports,
        speed=setup.mission.speed,
        epoch_ns=epoch_ns,
        slips=True,
        allowed_us=lambda: allowed_us,
        on_step=look,
        stop=stop,
    )


if __name__ == "__main__":
    sys.exit(main())
