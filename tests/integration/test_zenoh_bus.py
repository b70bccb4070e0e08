"""The live bus with its processes and failures: routers, refusals, exits, the example."""

import re
import signal
import socket
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import pytest

from uavbridge.bus import keys
from uavbridge.bus.api import Sample
from uavbridge.bus.messages import FullMap, Readings, decode_readings, encode_map
from uavbridge.bus.zenoh_bus import Router, ZenohBus
from uavbridge.errors import BusError

pytestmark = pytest.mark.integration

DOCS = Path(__file__).parents[2] / "docs"
EXAMPLE = DOCS / "examples/watch_beliefs.py"
TUTORIAL = DOCS / "tutorial/watch_over_zenoh.md"


@pytest.fixture
def router() -> Iterator[Router]:
    with Router() as router:
        yield router


@pytest.fixture
def taken() -> Iterator[str]:
    """An endpoint where something else listens, and never says a word."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        yield f"tcp/127.0.0.1:{server.getsockname()[1]}"


@pytest.fixture
def free() -> str:
    with socket.create_server(("127.0.0.1", 0)) as server:
        return f"tcp/127.0.0.1:{server.getsockname()[1]}"


def until(happened: Callable[[], object], patience_s: float = 5.0) -> None:
    deadline = time.monotonic() + patience_s
    while not happened():
        assert time.monotonic() < deadline
        time.sleep(0.005)


def one_line(error: BusError, endpoint: str) -> bool:
    text = str(error)
    return "\n" not in text and endpoint in text and ".rs" not in text and len(text) < 120


def test_a_router_that_is_not_there_is_named(free: str) -> None:
    with pytest.raises(BusError, match="no zenoh router") as caught:
        ZenohBus(free, "m")
    assert one_line(caught.value, free)


def test_an_endpoint_that_never_answers_is_given_up(taken: str) -> None:
    start = time.monotonic()
    with pytest.raises(BusError, match="no zenoh router") as caught:
        ZenohBus(taken, "m")
    assert time.monotonic() - start < 4.0
    assert one_line(caught.value, taken)


@pytest.mark.parametrize("endpoint", ["nonsense", "tcp/127.0.0.1:port", "smoke/signals:1"])
def test_an_endpoint_that_makes_no_sense_is_named(endpoint: str) -> None:
    for use in (lambda: ZenohBus(endpoint, "m"), lambda: Router(endpoint)):
        with pytest.raises(BusError) as caught:
            use()
        assert one_line(caught.value, endpoint)


def test_a_port_in_use_is_named_and_auto_takes_another(taken: str) -> None:
    with pytest.raises(BusError, match="in use") as caught:
        Router(taken)
    assert one_line(caught.value, taken)
    with Router() as one, Router() as two:
        assert one.endpoint != two.endpoint
        with ZenohBus(one.endpoint, "m") as here, ZenohBus(two.endpoint, "m") as there:
            assert here.connected
            assert there.connected


def test_a_session_may_wait_for_its_router(free: str) -> None:
    start = threading.Timer(0.3, lambda: routers.append(Router(free)))
    routers: list[Router] = []
    start.start()
    with ZenohBus(free, "m", wait_s=5.0) as bus:
        assert bus.connected
    routers[0].close()


def test_missions_on_one_router_do_not_hear_each_other(router: Router) -> None:
    with ZenohBus(router.endpoint, "one") as one, ZenohBus(router.endpoint, "two") as two:
        mine, other = one.subscribe("**"), two.subscribe("**")
        until(lambda: one.publish("air/0/0/1", b"x") or mine.drain())
        assert other.drain() == []
        assert one.delivered > 0


def test_sessions_find_a_router_that_came_back(free: str) -> None:
    router = Router(free)
    with ZenohBus(free, "m") as a, ZenohBus(free, "m") as b:
        box = b.subscribe("air/**")
        alive, changes = b.watch("alive/*"), list[bytes]()
        a.serve("state/1/map", lambda _: b"map")
        a.declare("alive/1")
        until(lambda: a.publish("air/0/0/1", b"before") or box.drain())
        router.close()
        until(lambda: not a.connected)
        a.publish("air/0/0/1", b"nobody hears")
        router = Router(free)
        start = time.monotonic()
        until(lambda: a.publish("air/0/0/1", b"after") or box.drain())
        assert time.monotonic() - start < 1.0
        until(lambda: b.query("state/*/map"))
        until(lambda: seen(alive.drain(), changes) == [b"1", b"", b"1"])
    router.close()


def seen(samples: list[Sample], into: list[bytes]) -> list[bytes]:
    into += [sample.data for sample in samples]
    return into


def test_a_reader_that_sleeps_loses_the_oldest_and_says_so(
    router: Router, caplog: pytest.LogCaptureFixture
) -> None:
    with ZenohBus(router.endpoint, "m", capacity=4) as bus:
        box = bus.subscribe("air/**")
        for i in range(10):
            bus.publish("air/0/0/1", b"%d" % i)
        until(lambda: box.overflows or box.drain())
        assert box.overflows == 1
        assert "may be lost" in caplog.text


@pytest.mark.parametrize("ending", ["raise SystemExit(3)", "raise ValueError('x')", "os.abort()"])
def test_a_process_that_forgets_to_close_ends_at_once(router: Router, ending: str) -> None:
    script = f"""
import os
from uavbridge.bus.zenoh_bus import Router, ZenohBus
bus = ZenohBus({router.endpoint!r}, "m")
boxes = [bus.subscribe("air/**"), bus.watch("alive/*")]
bus.serve("state/1/map", lambda key: b"map")
bus.declare("alive/1")
bus.publish("air/0/0/1", b"x")
router = Router()
{ending}
"""
    with ZenohBus(router.endpoint, "m") as bus:
        alive = bus.watch("alive/1")
        changes: list[bytes] = []
        done = subprocess.run(
            [sys.executable, "-c", script], capture_output=True, text=True, timeout=20
        )
        assert done.returncode != 0
        assert done.stdout == ""
        until(lambda: seen(alive.drain(), changes) == [b"1", b""])


def example_map(t_us: int) -> bytes:
    chance = np.array([[0.05, 0.5, 0.9], [0.25, 0.5, 1.0]])
    return encode_map(FullMap(3, t_us, 0.0, 0.0, 100.0, chance, np.full((2, 3), -1)))


@pytest.fixture
def watcher(router: Router, count: str) -> Iterator[subprocess.Popen[str]]:
    command = [sys.executable, str(EXAMPLE), "3", router.endpoint, count]
    pipe = subprocess.PIPE
    with subprocess.Popen(command, stdout=pipe, stderr=pipe, text=True) as process:
        yield process
        process.kill()


@pytest.mark.parametrize("count", ["2", "1000000"])
def test_the_example_prints_maps_and_ends(
    router: Router, watcher: subprocess.Popen[str], count: str
) -> None:
    printed: list[str] = []
    reading = threading.Thread(target=lambda: printed.extend(watcher.stdout or ()))
    reading.start()
    with ZenohBus(router.endpoint, "any mission") as bus:
        bus.serve(keys.state_map(3), lambda _: example_map(0))
        t_us = iter(range(500_000, 10**9, 500_000))
        while watcher.poll() is None and (count == "2" or len(printed) < 12):
            bus.publish(keys.state_map(3), example_map(next(t_us)))
            time.sleep(0.02)
    if count != "2":
        watcher.send_signal(signal.SIGINT)
    assert watcher.wait(10) == 0
    reading.join()
    assert watcher.stderr is not None
    assert watcher.stderr.read() == ""
    assert len(printed) >= 12
    for i in range(0, 12, 4):
        title, *rows = printed[i : i + 4]
        assert re.fullmatch(r"agent 3 at \d+\.\d s, north up:\n", title)
        assert [row.strip("[] \n") for row in rows] == ["0.9  1.", "0.5  0.5", "0.05 0.25"]


def tutorial(router: Router) -> list[str]:
    """The tutorial's Python, for this router."""
    blocks = re.findall(r"```python\n(.*?)```", TUTORIAL.read_text(), re.DOTALL)
    return [block.replace("tcp/127.0.0.1:7447", router.endpoint) for block in blocks]


def test_the_tutorial_shows_the_example(router: Router) -> None:
    assert EXAMPLE.read_text() in TUTORIAL.read_text()
    assert len(tutorial(router)) == 4


def test_the_tutorials_listener_hears_everything(router: Router) -> None:
    command = [sys.executable, "-uc", tutorial(router)[1]]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as listener:
        assert listener.stdout is not None
        with ZenohBus(router.endpoint, "liu2022") as bus, ThreadPoolExecutor(1) as reader:
            line = reader.submit(listener.stdout.readline)
            until(lambda: bus.publish("air/0/0/3", b"abc") or line.done())
        listener.kill()
    assert line.result() == "uavbridge/liu2022/air/0/0/3 3 bytes\n"


def test_the_tutorials_detector_is_understood(router: Router) -> None:
    with ZenohBus(router.endpoint, "liu2022") as bus:
        box = bus.subscribe(keys.obs(3))
        samples: list[Sample] = []
        until(lambda: exec(tutorial(router)[2]) or samples.extend(box.drain()) or samples)
    assert decode_readings(samples[0].data) == Readings(60_000_000, ((4, 7, True),))


def test_the_tutorials_program_reads_maps(
    router: Router, capsys: pytest.CaptureFixture[str]
) -> None:
    with ZenohBus(router.endpoint, "liu2022") as bus:
        bus.serve(keys.state_map(3), lambda _: example_map(0))
        until(lambda: exec(tutorial(router)[3], {}) or capsys.readouterr().out.startswith("3 0.0"))


LISTENER = """
import sys, zenoh
config = zenoh.Config()
config.insert_json5("mode", '"client"')
config.insert_json5("connect/endpoints", f'["{sys.argv[1]}"]')
session = zenoh.open(config)
listening = session.declare_subscriber("uavbridge/**", lambda sample: None)
print("ready", flush=True)
sys.stdin.read()
session.close()
"""


def test_a_frozen_monitor_holds_up_nobody(router: Router) -> None:
    command = [sys.executable, "-c", LISTENER, router.endpoint]
    pipe = subprocess.PIPE
    with (
        subprocess.Popen(command, stdin=pipe, stdout=pipe) as monitor,
        ZenohBus(router.endpoint, "m") as sender,
        ZenohBus(router.endpoint, "m") as receiver,
    ):
        assert monitor.stdout is not None
        assert monitor.stdout.readline() == b"ready\n"
        inbox = receiver.subscribe("obs/*")
        until(lambda: sender.publish(keys.obs(1), b"there?") or inbox.drain())
        monitor.send_signal(signal.SIGSTOP)
        began, heard, payload = time.monotonic(), [], bytes(20_000)
        for number in range(1000):
            sender.publish(keys.state_map(number % 10), payload)
            sender.publish(keys.obs(2), b"%d" % number)
            heard += [sample.data for sample in inbox.drain() if sample.key == keys.obs(2)]
        took_s = time.monotonic() - began
        monitor.kill()
        until(lambda: heard.extend(s.data for s in inbox.drain()) or heard[-1:] == [b"999"])
        assert len(heard) == 1000
        assert took_s < 3.0
