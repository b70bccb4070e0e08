"""Suballiance messages as bytes."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.conformance import PAYLOAD_BYTES
from planners.search.mountain.payload import FOUND_AT_ONCE, Told, decode, encode

NUMBER = st.floats(allow_nan=False, allow_infinity=False)
IDS = st.lists(st.integers(0, 2**32 - 1), max_size=16).map(tuple)
TOLD = st.builds(
    Told,
    task=st.integers(-1, 2**31 - 1),
    first=st.booleans(),
    free=st.booleans(),
    leads=st.booleans(),
    strength=NUMBER,
    best=NUMBER | st.just(-math.inf),
    best_place=st.tuples(NUMBER, NUMBER, NUMBER),
    roster=IDS,
    found=IDS,
)


@given(TOLD, st.integers(0, 10**6))
def test_round_trip(told, tick):
    assert decode(encode(told, tick), 16) == told
    assert len(encode(told, tick)) <= PAYLOAD_BYTES


@given(st.binary(max_size=300))
def test_any_bytes_are_a_message_or_an_empty_one(data):
    told = decode(data, 6)
    assert len(told.roster) <= 6
    assert math.isfinite(told.strength)


@given(TOLD, st.data())
def test_cut_bytes_are_an_empty_message(told, data):
    whole = encode(told, 0)
    assert decode(whole[: data.draw(st.integers(0, len(whole) - 1))], 16) == Told()


@pytest.mark.parametrize(
    "wrong",
    [
        Told(strength=math.nan),
        Told(best=math.inf),
        Told(best=math.nan),
        Told(best_place=(0.0, math.inf, 0.0)),
        Told(task=-2),
        Told(roster=tuple(range(7))),
    ],
)
def test_nonsense_is_an_empty_message(wrong):
    assert decode(encode(wrong, 0), 6) == Told()


def test_many_found_targets_take_turns():
    told = Told(found=tuple(range(100)))
    heard = set()
    for tick in range(25):
        part = decode(encode(told, tick), 6).found
        assert len(part) == FOUND_AT_ONCE
        heard.update(part)
    assert heard == set(range(100))
