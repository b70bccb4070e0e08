"""CPU per delivered frame: the bus against raw zenoh with the same bytes, in one run.

Three processes: a router, one that sends as SENDERS agents, one that receives. The
raw one puts and collects the same bytes with plain zenoh; the bus encodes, decodes,
judges by range on true positions, sorts and keeps accounts. Shown is the CPU of
sender and receiver together; the router forwards the same bytes in both.

python tests/benchmarks/bench_bus.py [TICKS]
"""

import json
import os
import resource
import subprocess
import sys
import time
from collections.abc import Callable
from typing import Any

import numpy as np

from uavbridge.bus.air import Air
from uavbridge.bus.tiles import Tiling
from uavbridge.bus.truth import TruthTrack
from uavbridge.bus.wire import DELTA, Frame, Vector, encode
from uavbridge.bus.zenoh_bus import Router, ZenohBus
from uavbridge.radio import Radio

SENDERS = 20
PERIOD_S = 0.02
START_TICKS = 50  # the receiver listens longer, as the sender starts after it
TICK_US = 500_000
RANGE_M = 400.0
HEARD = (1 << SENDERS) - 1
STILL = (0.0, 0.0, 0.0)
CELLS = bytes(10 * 25)
LIMIT = 2.0  # CPU of the bus to that of raw zenoh, one agent a process
MODES = {"raw zenoh": 1, "bus": 1, "bus, 10 agents": 10}


def cpu_s() -> float:
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def place(sender: int) -> Vector:
    return (10.0 * sender, 0.0, 50.0)


def frame(sender: int, tick: int) -> Frame:
    return Frame(
        DELTA, sender, tick, tick * TICK_US, place(sender), STILL, b"", 1, CELLS, heard=HEARD
    )


def raw_session(endpoint: str) -> Any:
    import zenoh

    config = zenoh.Config()
    config.insert_json5("mode", '"client"')
    config.insert_json5("connect/endpoints", json.dumps([endpoint]))
    return zenoh.open(config)


def send(mode: str, endpoint: str, ticks: int) -> float:
    """CPU seconds spent on sending."""
    if mode == "raw zenoh":
        session = raw_session(endpoint)
        samples = [(f"uavbridge/bench/air/0/0/{i}", encode(frame(i, 0))) for i in range(SENDERS)]

        def one(_: int) -> None:
            for key, data in samples:
                session.put(key, data)

        return timed(one, ticks, session.close)
    bus = ZenohBus(endpoint, "bench")
    air = Air(bus, Radio(RANGE_M), range(SENDERS), Tiling.of(RANGE_M, 10.0))
    frames = [[frame(i, tick) for i in range(SENDERS)] for tick in range(ticks + 1)]

    def many(tick: int) -> None:
        for message in frames[tick]:
            air.send(message)

    air.close()
    return timed(many, ticks, bus.close)


def receive(mode: str, endpoint: str, ticks: int) -> tuple[float, int, int]:
    """CPU seconds spent on receiving, samples that came, frames that agents heard."""
    if mode == "raw zenoh":
        session, came = raw_session(endpoint), list[bytes]()
        session.declare_subscriber(
            "uavbridge/bench/air/**", lambda sample: came.append(sample.payload.to_bytes())
        )
        print("ready", flush=True)
        spent = timed(lambda _: None, ticks + START_TICKS, lambda: None)
        session.close()
        return spent, len(came), len(came)
    bus = ZenohBus(endpoint, "bench")
    agents = tuple(range(100, 100 + MODES[mode]))
    truth = TruthTrack(memory=ticks)
    air = Air(bus, Radio(RANGE_M), agents, Tiling.of(RANGE_M, 10.0), truth)
    ids = (*range(SENDERS), *agents)
    spots = np.array([place(i) for i in range(SENDERS)] + [STILL for _ in agents])
    for tick in range(ticks + 2):
        truth.add(tick * TICK_US, ids, spots)
    positions = dict.fromkeys(agents, STILL)
    heard = 0

    def one(tick: int) -> None:
        nonlocal heard
        heard += sum(len(inbox) for inbox in air.receive(positions, ticks * TICK_US).values())

    air.receive(positions, 0)
    print("ready", flush=True)
    spent = timed(one, ticks + START_TICKS, lambda: None)
    bus.close()
    return spent, air.arrivals, heard


def timed(step: Callable[[int], None], ticks: int, close: Callable[[], None]) -> float:
    """CPU of ``ticks`` paced steps and of half a second after them."""
    start, before = time.monotonic(), cpu_s()
    for tick in range(ticks):
        step(tick)
        time.sleep(max(0.0, start + (tick + 1) * PERIOD_S - time.monotonic()))
    time.sleep(0.5)
    step(ticks)
    spent = cpu_s() - before
    close()
    return spent


def measure(mode: str, endpoint: str, ticks: int) -> tuple[float, float, int, int]:
    """CPU seconds of sender and receiver, samples, frames heard."""
    base = [sys.executable, __file__, mode, endpoint, str(ticks)]
    with subprocess.Popen([*base, "receive"], stdout=subprocess.PIPE, text=True) as receiver:
        assert receiver.stdout is not None
        assert receiver.stdout.readline() == "ready\n"
        time.sleep(0.2)
        sender = subprocess.run([*base, "send"], stdout=subprocess.PIPE, text=True, check=True)
        spent, came, heard = json.loads(receiver.stdout.readline())
    return json.loads(sender.stdout), spent, came, heard


def main(ticks: int = 300) -> None:
    print(f"{SENDERS} senders, frames of {len(encode(frame(0, 0)))} bytes, {ticks} ticks")
    print("                     CPU us per frame: send   receive   per frame heard      ratio")
    yardstick = 0.0
    with Router() as router:
        for mode in MODES:
            sent_s, received_s, came, heard = measure(mode, router.endpoint, ticks)
            each = 1e6 * (sent_s + received_s) / max(heard, 1)
            yardstick = yardstick or each
            sending, receiving = 1e6 * sent_s / (ticks * SENDERS), 1e6 * received_s / max(came, 1)
            print(f"{mode:16s}{sending:26.1f}{receiving:10.1f}{each:16.1f}{each / yardstick:14.2f}")
            print(f"{'':16s}{came} of {ticks * SENDERS + SENDERS} samples came")
            if MODES[mode] == 1 and each > LIMIT * yardstick:
                sys.exit(f"the bus costs more than {LIMIT:g} times raw zenoh")


if __name__ == "__main__":
    if len(sys.argv) == 5:
        mode, endpoint, count, role = sys.argv[1:]
        run: Callable[..., Any] = send if role == "send" else receive
        print(json.dumps(run(mode, endpoint, int(count))), flush=True)
        os._exit(0)
    main(*map(int, sys.argv[1:]))
