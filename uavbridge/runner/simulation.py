"""The simulation's process, from outside (``Simulation``) and from inside (``main``).

The child gets one JSON line on standard input: the mission with its targets, the
UDP port of each agent's vehicle, and the router. It answers ``ready``, gets the
moment of mission start, and runs until its standard input closes: whatever
happens to its parent, it ends.
"""

from __future__ import annotations

import subprocess
import sys
import threading
from types import TracebackType
from typing import Self

import msgspec
from msgspec import Struct

from uavbridge.bus.zenoh_bus import ZenohBus
from uavbridge.clock import PacedClock
from uavbridge.config import Mission
from uavbridge.errors import UavbridgeError
from uavbridge.runner import assemble
from uavbridge.runner.world import SimulatedWorld

START_IN_S = 0.1  # from the word to mission start
PATIENCE_S = 5.0  # for a child that was told to end


class Order(Struct, frozen=True):
    """What the child is told first."""

    mission: Mission
    ports: dict[int, int]  # agent -> UDP port its vehicle speaks to
    router: str
    speed: float


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
        )
        self._say(msgspec.json.encode(Order(mission, ports, router, mission.speed)))

    def start(self) -> PacedClock:
        """Wait for the child to be ready and let mission time begin; the clock both share.

        Raises:
            UavbridgeError: the simulation could not start.
        """
        if self._process is None:
            return PacedClock(self._speed)
        assert self._process.stdout is not None
        if self._process.stdout.readline() != b"ready\n":
            raise UavbridgeError("the simulation could not start")
        epoch_ns = PacedClock(self._speed).epoch_ns + int(START_IN_S * 1e9)
        self._say(str(epoch_ns).encode())
        return PacedClock(self._speed, epoch_ns=epoch_ns)

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
        self._process.stdin.close()
        try:
            self._process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._process.stdout.close()
        self._process = None

    def _say(self, line: bytes) -> None:
        assert self._process is not None
        assert self._process.stdin is not None
        self._process.stdin.write(line + b"\n")
        self._process.stdin.flush()

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()


def main() -> int:
    """The child: serve the vehicles until standard input closes."""
    order = msgspec.json.decode(sys.stdin.buffer.readline(), type=Order)
    agents = tuple(sorted(order.ports))
    fleet = assemble.fleet_of(order.mission, agents)
    with ZenohBus(order.router, order.mission.name) as bus:
        world = SimulatedWorld(fleet, agents, assemble.sensor_of(order.mission, agents), bus)
        sys.stdout.write("ready\n")
        sys.stdout.flush()
        line = sys.stdin.buffer.readline()
        if not line:
            return 0
        stop = threading.Event()
        threading.Thread(target=_wait_for_end, args=(stop,), daemon=True).start()
        serve(fleet, world, order, int(line), stop)
    return 0


def _wait_for_end(stop: threading.Event) -> None:
    sys.stdin.buffer.read()
    stop.set()


if __name__ == "__main__":
    sys.exit(main())
