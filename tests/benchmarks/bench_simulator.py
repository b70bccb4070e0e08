"""Cost of the simulator in flight, over UDP: python tests/benchmarks/bench_simulator.py.

CPU of the whole simulator process (user and system), everything on: dynamics, autopilots,
default streams from a socket a vehicle to a process that reads them. "x real time" is
simulated seconds per CPU second: what one core can do. The baseline packs the same
telemetry with pymavlink, and does nothing else.
"""

from __future__ import annotations

import asyncio
import multiprocessing
import os
import socket
import time
from math import inf
from multiprocessing.connection import Connection

from sim_vehicles.codec import Counts, Encoder, decode, mav
from sim_vehicles.fleet import Fleet, VehicleSpec
from sim_vehicles.geodesy import Geodetic
from sim_vehicles.ports import seats
from sim_vehicles.server import serve
from sim_vehicles.udp import UdpPorts

DURATIONS_S = {1: 60.0, 10: 60.0, 100: 30.0, 1000: 10.0}  # vehicles -> simulated seconds
GOALS = {100: 20.0, 1000: 4.0}  # vehicles -> x real time on one core
SETPOINT_US = 200_000
HOME = Geodetic(47.397742, 8.545594, 488.0)
POSITION_ONLY = 0xDF8


def cpu_s() -> float:
    return sum(os.times()[:4])


def fleet_of(n: int) -> Fleet:
    specs = [
        VehicleSpec(seat.system, (i % 32 * 10.0, i // 32 * 10.0, 0.0), in_air_m=20.0)
        for i, seat in enumerate(seats(n))
    ]
    return Fleet(specs, origin=HOME)


class Commander:
    """Sends every vehicle round a square by offboard setpoints, five a second."""

    def __init__(self, fleet: Fleet) -> None:
        own = Encoder(255, 190)
        self._start = [
            own.pack("SET_MODE", target_system=system, base_mode=1, custom_mode=6 << 16)
            for system in fleet.systems
        ]
        self._setpoints = [
            [
                own.pack(
                    "SET_POSITION_TARGET_LOCAL_NED",
                    target_system=system,
                    target_component=1,
                    coordinate_frame=mav.MAV_FRAME_LOCAL_NED,
                    type_mask=POSITION_ONLY,
                    x=x,
                    y=y,
                    z=-20.0,
                )
                for system in fleet.systems
            ]
            for x, y in ((40.0, 0.0), (40.0, 40.0), (0.0, 40.0), (0.0, 0.0))
        ]

    def __call__(self, fleet: Fleet, t_us: int) -> None:
        if t_us % SETPOINT_US:
            return
        for i, frame in enumerate(self._setpoints[t_us // 8_000_000 % 4]):
            fleet.receive(i, frame)
            if t_us == SETPOINT_US:
                fleet.receive(i, self._start[i])


def measure(n: int, targets: list[int], offboard: bool) -> tuple[float, float, int]:
    """CPU seconds per simulated second, the same of the wall, and datagrams sent."""
    fleet = fleet_of(n)
    commander = Commander(fleet) if offboard else None

    async def fly(seconds: float) -> tuple[float, float, int]:
        transport = UdpPorts("127.0.0.1", targets)
        before = cpu_s()
        report = await serve(fleet, transport, speed=inf, duration_s=seconds, on_step=commander)
        return cpu_s() - before, report.wall_s, report.traffic.datagrams_out

    asyncio.run(fly(1.0))  # warm up
    seconds = DURATIONS_S[n]
    used, wall, sent = asyncio.run(fly(seconds))
    modes = set(fleet.truth().modes)
    assert all(fleet.truth().in_air), "vehicles fell down"
    assert len(modes) == 1, modes
    return used / seconds, wall / seconds, sent


def packing_cost(n: int) -> tuple[float, float]:
    """CPU seconds per simulated second to make telemetry: by us, and packed by pymavlink."""
    fleet = fleet_of(n)
    seconds = max(2000 / n, 2.0)
    squad = fleet.squads[0]
    telemetry, snapshot = squad.telemetry, squad.report.snapshot
    steps = range(20_000, round(seconds * 1e6), 20_000)
    before = time.process_time()
    datagrams = [sent for t_us in steps for sent in telemetry.build(t_us, snapshot)]
    ours = time.process_time() - before
    senders = [mav.MAVLink(None, system, 1) for system in fleet.systems]
    work = []
    for i, datagram in datagrams:
        for packet in decode(datagram, Counts()):
            kind = mav.mavlink_map[packet.message.msgid]
            work.append((kind, packet.message._asdict(), senders[i]))
    before = time.process_time()
    for kind, values, sender in work:
        sender.seq = (sender.seq + 1) % 256
        kind(**values).pack(sender)
    return ours / seconds, (time.process_time() - before) / seconds


def drain(ready: Connection, count: int) -> None:
    """Read what arrives on ``count`` ports, until killed."""
    sockets = [socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(count)]
    for opened in sockets:
        opened.bind(("127.0.0.1", 0))
        opened.settimeout(0.02)
    ready.send([opened.getsockname()[1] for opened in sockets])
    while True:
        for opened in sockets:
            try:
                for _ in range(1000):
                    opened.recv(2048)
            except TimeoutError:
                continue


def row(name: str, n: int, used: float, wall: float) -> str:
    goal = GOALS.get(n)
    verdict = "" if goal is None else f"  goal x{goal:g}: {'met' if used * goal < 1 else 'MISSED'}"
    return (
        f"{name:10}{n:6}{used / n:14.2e}{1 / used:12.1f}{1 / wall:10.1f}"
        f"{0.027 / (used / n):12.0f}{0.15 / (used / n):10.0f}{verdict}"
    )


def main() -> None:
    context = multiprocessing.get_context("spawn")
    here, there = context.Pipe()
    sink = context.Process(target=drain, args=(there, 4), daemon=True)
    sink.start()
    sinks = here.recv()
    print(
        f"{'flying':10}{'n':>6}{'CPU s/veh s':>14}{'x real time':>12}{'x wall':>10}"
        f"{'ArduCopter/':>12}{'PX4 SIH/':>10}"
    )
    for n in DURATIONS_S:
        targets = [sinks[i // 250] for i in range(n)]
        for name, offboard in (("hold", False), ("offboard", True)):
            used, wall, _ = measure(n, targets, offboard)
            print(row(name, n, used, wall), flush=True)
    sink.terminate()
    sink.join()
    print(f"\n{'telemetry':10}{'n':>6}{'ours':>14}{'pymavlink':>12}{'ratio':>10}   CPU s/veh s")
    for n in DURATIONS_S:
        ours, theirs = min((packing_cost(n) for _ in range(3)), key=sum)
        print(f"{'':10}{n:6}{ours / n:14.2e}{theirs / n:12.2e}{theirs / ours:10.1f}")


if __name__ == "__main__":
    main()
