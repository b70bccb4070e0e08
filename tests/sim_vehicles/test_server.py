"""The paced loop, without a network; and the command line's answers to bad input."""

import asyncio
import logging
from math import inf

import pytest
from click.testing import CliRunner

from sim_vehicles.command_line import main
from sim_vehicles.server import Pace, Report, serve
from sim_vehicles.transport import Both, Traffic


class Echo:
    """A fleet that tells the time and answers at once."""

    def __init__(self) -> None:
        self.now_us = 0
        self.steps: list[int] = []
        self._out: list[tuple[int, bytes]] = []

    def advance(self, until_us: int) -> None:
        self.now_us = until_us
        self.steps.append(until_us)
        self._out.append((0, b"%d" % until_us))

    def receive(self, index: int, datagram: bytes) -> None:
        self._out.append((index, b"heard " + datagram))

    def transmit(self) -> list[tuple[int, bytes]]:
        out, self._out = self._out, []
        return out


class Wire:
    """A transport that keeps what is sent and delivers one datagram at the start."""

    def __init__(self, *arriving: tuple[int, bytes]) -> None:
        self.traffic = Traffic()
        self.sent: list[tuple[int, bytes]] = []
        self.closed = False
        self._arriving = arriving

    async def start(self, loop, receive) -> None:
        for index, datagram in self._arriving:
            receive(index, datagram)

    def send(self, index: int, datagram: bytes) -> None:
        self.sent.append((index, datagram))

    def close(self) -> None:
        self.closed = True


def run(fleet: Echo, wire: Wire, **options) -> Report:
    return asyncio.run(serve(fleet, wire, **options))


def test_as_fast_as_it_can_for_a_duration():
    fleet, wire = Echo(), Wire()
    report = run(fleet, wire, speed=inf, duration_s=2.0, period_s=0.1)
    assert fleet.steps == list(range(100_000, 2_000_001, 100_000))
    assert wire.sent == [(0, b"%d" % t) for t in fleet.steps]
    assert wire.closed
    assert report.simulated_s == 2.0
    assert not report.late


def test_answers_that_are_late_for_the_end_are_dropped():
    class Closing(Wire):
        async def start(self, loop, receive) -> None:
            self.receive = receive

        def send(self, index: int, datagram: bytes) -> None:
            if self.closed:
                failures.append(datagram)

    async def fly() -> None:
        loop = asyncio.get_running_loop()
        await serve(
            Echo(),
            wire,
            speed=inf,
            duration_s=0.02,
            on_step=lambda *_: loop.call_soon(wire.receive, 0, b"late"),  # as a socket would
        )
        await asyncio.sleep(0.01)

    failures: list[bytes] = []
    wire = Closing()
    asyncio.run(fly())
    assert wire.closed
    assert not failures


def test_two_transports_are_one():
    first, second = Wire((0, b"a")), Wire((1, b"b"))
    first.traffic.bytes_out, second.traffic.bytes_out = 3, 4
    both = Both(first, second)
    run(Echo(), both, speed=inf, duration_s=0.02)
    assert (0, b"heard a") in first.sent
    assert first.sent == second.sent
    assert first.closed
    assert second.closed
    assert both.traffic == Traffic(bytes_out=7)


@pytest.mark.parametrize("text", ["14550x", "host:", "host:0", "host:70000", ":-1"])
def test_bad_ground_stations(text):
    result = CliRunner().invoke(main, ["--gcs", text])
    assert result.exit_code == 2
    assert "--gcs" in result.output


def test_each_step_is_told():
    told = []
    run(
        Echo(),
        Wire(),
        speed=inf,
        duration_s=0.06,
        on_step=lambda fleet, t_us: told.append((fleet.now_us, t_us)),
    )
    assert told == [(t, t) for t in (20_000, 40_000, 60_000)]


def test_answers_do_not_wait_for_the_next_step():
    wire = Wire((3, b"hello"), (4, b"there"))
    run(Echo(), wire, speed=inf, duration_s=0.02)
    assert {(3, b"heard hello"), (4, b"heard there")} <= set(wire.sent)


def test_it_keeps_to_the_clock():
    fleet = Echo()
    report = run(fleet, Wire(), speed=50.0, duration_s=5.0)
    assert report.wall_s >= 0.08
    assert report.rate <= 60


def test_a_stop_ends_it_and_closes_the_ports():
    async def stopped() -> tuple[Report, Wire]:
        stop, wire = asyncio.Event(), Wire()
        asyncio.get_running_loop().call_later(0.02, stop.set)
        return await serve(Echo(), wire, speed=1.0, stop=stop), wire

    report, wire = asyncio.run(stopped())
    assert wire.closed
    assert report.simulated_s < 1.0


def test_an_error_of_the_fleet_closes_the_ports_too():
    class Broken(Echo):
        def advance(self, until_us: int) -> None:
            raise ZeroDivisionError

    wire = Wire()
    with pytest.raises(ZeroDivisionError):
        run(Broken(), wire, speed=inf)
    assert wire.closed


def test_falling_behind_is_said_once_and_nothing_is_left_out(caplog):
    fleet = Echo()
    with caplog.at_level(logging.WARNING):
        report = run(fleet, Wire(), speed=1e7, duration_s=20.0, epoch_ns=0)
    assert report.late
    assert [r.message for r in caplog.records if "keep up" in r.message] != []
    assert len(caplog.records) == 1
    assert len(fleet.steps) == 1000


def test_a_pace_without_epoch_gives_up_what_is_lost():
    pace = Pace(100.0, 2.0, None)
    assert pace.left_s(4_000_000, 100.0) == 2.0
    pace.slip(5.0)
    assert pace.left_s(4_000_000, 105.0) == 2.0


def test_a_shared_epoch_never_moves():
    pace = Pace(100.0, 2.0, 90 * 10**9)
    assert pace.left_s(0, 100.0) == -10.0
    pace.slip(5.0)
    assert pace.left_s(0, 100.0) == -10.0


def test_a_shared_epoch_moves_where_that_is_wanted():
    pace = Pace(100.0, 2.0, 90 * 10**9, slips=True)
    pace.slip(10.0)
    assert pace.left_s(0, 100.0) == 0.0


def test_it_goes_no_further_than_allowed():
    fleet = Echo()
    seen = []

    def allowed() -> int:
        seen.append(fleet.now_us)
        return 20_000 * len(seen)

    run(fleet, Wire(), speed=inf, duration_s=0.2, allowed_us=allowed)
    assert len(fleet.steps) == 10
    assert all(t_us < 20_000 * (n + 1) for n, t_us in enumerate(seen))


def test_time_does_not_go_back():
    with pytest.raises(ValueError, match="speed"):
        Pace(0.0, 0.0, None)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["--count", "0"], "--count"),
        (["--speed", "0"], "--speed"),
        (["--speed", "nan"], "--speed"),
        (["--in-air", "inf"], "--in-air"),
        (["--home", "91,0,0"], "latitude"),
        (["--home", "here"], "--home"),
        (["--wind", "1,2"], "--wind"),
        (["--wind", "1,nan,0"], "finite"),
        (["--port", "70000"], "--port"),
        (["--port", "65535", "--count", "2"], "ports must be"),
        (["--model", "balloon"], "--model"),
        (["--ports", "some"], "--ports"),
        (["--nonsense"], "--nonsense"),
    ],
)
def test_bad_arguments_are_named(arguments, says):
    result = CliRunner().invoke(main, arguments)
    assert result.exit_code == 2
    assert says in result.output
    assert "Traceback" not in result.output
