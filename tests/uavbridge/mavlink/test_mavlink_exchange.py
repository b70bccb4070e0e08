"""The transition table of one exchange, commands and parameters on it."""

from __future__ import annotations

import struct
from collections.abc import Iterable
from math import isnan
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from sim_vehicles.codec import Counts, Encoder, decode, mav
from uavbridge.mavlink.commands import DEFAULTS, Commands, Order, Verdict
from uavbridge.mavlink.exchange import OVER, TABLE, Event, Exchange, Patience, State
from uavbridge.mavlink.parameters import Kind, Parameters, from_wire, to_wire

SECOND = 1_000_000
ARM = Order(mav.MAV_CMD_COMPONENT_ARM_DISARM, (1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
MODE = Order(mav.MAV_CMD_DO_SET_MODE, (1.0, 4.0, 3.0, 0.0, 0.0, 0.0, 0.0))


def ack(command: int, result: int = 0) -> Any:
    return SimpleNamespace(command=command, result=result)


def messages(frames: Iterable[bytes]) -> list[Any]:
    return [packet.message for frame in frames for packet in decode(frame, Counts())]


def fresh(**patience: Any) -> Commands:
    return Commands(Encoder(245, 190), 7, patience=Patience(**patience))


def run(commands: Commands, until_s: float, start_s: float = 0.0) -> list[tuple[float, Any]]:
    """What is sent, and when, with nobody answering."""
    sent = []
    for step in range(round(start_s * 10), round(until_s * 10) + 1):
        t_us = step * SECOND // 10
        sent += [(t_us / SECOND, message) for message in messages(commands.due(t_us))]
    return sent


@given(st.lists(st.sampled_from(Event), max_size=30))
def test_an_exchange_that_is_over_stays_so(events: list[Event]) -> None:
    exchange = Exchange(Patience(tries=3), 0)
    ended: State | None = None
    for event in events:
        exchange.hear(event, 0)
        if ended is not None:
            assert exchange.state is ended
        elif exchange.over:
            ended = exchange.state


def test_every_state_that_is_not_over_can_time_out() -> None:
    for state in set(State) - OVER - {State.WAITING}:
        assert TABLE[state, Event.TIMER] is State.SENT
        assert TABLE[state, Event.LAST] in OVER
    assert not any(state in OVER for state, _ in TABLE)


@given(st.integers(1, 6), st.floats(0.1, 2.0))
def test_silence_is_asked_for_as_often_as_patience_says(tries: int, retry_s: float) -> None:
    commands = fresh(tries=tries, retry_s=retry_s)
    ticket = commands.ask(ARM, 0)
    sent = run(commands, tries * (retry_s + 0.2) + 1.0)
    assert [message.confirmation for _, message in sent] == list(range(tries))
    assert commands.take() == [Verdict(ticket, False, "no answer")]
    assert commands.idle


def test_a_command_is_sent_once_when_answered() -> None:
    commands = fresh()
    ticket = commands.ask(ARM, 0)
    (message,) = messages(commands.due(0))
    assert (message.command, message.param1, message.target_system) == (400, 1.0, 7)
    commands.hear(ack(400), 1000)
    assert commands.take() == [Verdict(ticket, True)]
    assert run(commands, 5.0) == []


def test_in_progress_waits_longer_but_not_for_ever() -> None:
    commands = fresh(tries=2, retry_s=0.5, working_s=3.0)
    commands.ask(ARM, 0)
    commands.due(0)
    commands.hear(ack(400, mav.MAV_RESULT_IN_PROGRESS), 0)
    assert [t for t, _ in run(commands, 6.0, 0.1)] == [3.0]
    assert not commands.take()[0].accepted


@pytest.mark.parametrize(
    ("result", "word"),
    [(1, "temporarily rejected"), (2, "denied"), (3, "not supported"), (4, "failed"), (99, "99")],
)
def test_a_refusal_says_which(result: int, word: str) -> None:
    commands = fresh()
    commands.ask(ARM, 0)
    commands.due(0)
    commands.hear(ack(400, result), 0)
    (verdict,) = commands.take()
    assert not verdict.accepted
    assert word in verdict.reason


def test_a_persistent_order_is_asked_again_when_refused() -> None:
    commands = fresh(tries=3, retry_s=0.5)
    commands.ask(Order(176, MODE.params, persistent=True), 0)
    for t_us in (0, SECOND // 2, SECOND):
        assert len(commands.due(t_us)) == 1
        commands.hear(ack(176, mav.MAV_RESULT_DENIED), t_us)
    commands.due(2 * SECOND)
    assert commands.take() == [Verdict(1, False, "denied")]


def test_a_persistent_order_is_not_asked_again_for_what_is_not_supported() -> None:
    commands = fresh()
    commands.ask(Order(176, MODE.params, persistent=True), 0)
    commands.due(0)
    commands.hear(ack(176, mav.MAV_RESULT_UNSUPPORTED), 0)
    assert commands.take() == [Verdict(1, False, "not supported")]


def test_the_second_of_two_acks_is_not_taken_for_the_next_command() -> None:
    """PX4 answers DO_SET_MODE twice, 0 to 5 ms apart."""
    commands = fresh()
    first = commands.ask(MODE, 0)
    commands.due(0)
    commands.hear(ack(176), 3000)
    second = commands.ask(MODE, 4000)
    assert commands.due(4000) == []
    commands.hear(ack(176), 5000)
    assert commands.take() == [Verdict(first, True)]
    assert len(commands.due(400_000)) == 1
    commands.hear(ack(176, mav.MAV_RESULT_DENIED), 410_000)
    assert commands.take() == [Verdict(second, False, "denied")]


def test_different_commands_do_not_wait_for_each_other() -> None:
    commands = fresh()
    commands.ask(MODE, 0)
    arm = commands.ask(ARM, 0)
    assert {message.command for message in messages(commands.due(0))} == {176, 400}
    commands.hear(ack(400), 0)
    assert commands.take() == [Verdict(arm, True)]


def test_a_dropped_command_is_sent_no_more() -> None:
    commands = fresh()
    ticket = commands.ask(ARM, 0)
    commands.due(0)
    commands.drop(ticket, 0)
    assert run(commands, 5.0) == []
    assert commands.take() == []


def test_acks_of_nothing_asked_are_ignored() -> None:
    commands = fresh()
    commands.hear(ack(400), 0)
    assert commands.take() == []


def test_parameters_not_given_are_left_to_the_autopilot() -> None:
    (message,) = messages([fresh().frame(Order(22))])
    assert len(DEFAULTS) == 7
    assert all(isnan(getattr(message, f"param{number}")) for number in range(1, 8))


def test_command_int_carries_degrees_exactly() -> None:
    order = Order(192, (0.0, 1.0, 0.0, 0.5, 473977421.0, 85455941.0, 488.0), frame=5)
    (message,) = messages([fresh().frame(order)])
    assert message.msgname == "COMMAND_INT"
    assert (message.x, message.y, message.z, message.frame) == (473977421, 85455941, 488.0, 5)


def value(name: str, wire: float, kind: int = Kind.REAL32) -> Any:
    return SimpleNamespace(param_id=name, param_value=wire, param_type=kind)


def test_a_setting_is_done_when_the_new_value_is_shown() -> None:
    parameters = Parameters(Encoder(245, 190), 7)
    ticket = parameters.set("MIS_TAKEOFF_ALT", 12.3, Kind.REAL32, 0)
    (message,) = messages(parameters.due(0))
    assert message.msgname == "PARAM_SET"
    assert message.param_id == "MIS_TAKEOFF_ALT"
    parameters.hear(value("MIS_TAKEOFF_ALT", 2.5), 0)
    assert parameters.take() == []
    parameters.hear(value("MIS_TAKEOFF_ALT", message.param_value), 0)
    assert parameters.take() == [Verdict(ticket, True)]
    assert parameters.idle


def test_a_value_that_stays_is_named() -> None:
    parameters = Parameters(Encoder(245, 190), 7, patience=Patience(tries=1))
    parameters.set("A", 5.0, Kind.REAL32, 0)
    parameters.due(0)
    parameters.hear(value("A", 2.5), 0)
    parameters.due(SECOND)
    assert parameters.take()[0].reason == "A stays 2.5, not 5"


def test_a_reading_is_kept_and_silence_named() -> None:
    parameters = Parameters(Encoder(245, 190), 7, patience=Patience(tries=2))
    parameters.get("THERE", 0)
    parameters.get("NOWHERE", 0)
    sent = messages(parameters.due(0))
    assert {(m.msgname, m.param_id, m.param_index) for m in sent} == {
        ("PARAM_REQUEST_READ", "THERE", -1),
        ("PARAM_REQUEST_READ", "NOWHERE", -1),
    }
    parameters.hear(value("THERE", 4.0), 0)
    parameters.due(SECOND)
    parameters.due(2 * SECOND)
    good, bad = parameters.take()
    assert good.accepted
    assert parameters.values == {"THERE": 4.0}
    assert bad.reason == "no answer for parameter NOWHERE"


@given(st.integers(-(2**22), 2**30))
def test_whole_numbers_survive_as_bits(number: int) -> None:
    wire = to_wire(number, Kind.INT32, bytewise=True)
    assert from_wire(wire, Kind.INT32, bytewise=True) == number
    assert struct.pack("<f", wire) == struct.pack("<i", number)


def test_ardupilot_sends_whole_numbers_as_floats() -> None:
    assert to_wire(1, Kind.INT16, bytewise=False) == 1.0
    assert from_wire(1.0, Kind.INT16, bytewise=False) == 1.0
    with pytest.raises(ValueError, match="300 does not fit UINT8"):
        to_wire(300, Kind.UINT8, bytewise=True)
