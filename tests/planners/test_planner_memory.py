"""Memory through bytes."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.memory import dumps, loads


@dataclass(frozen=True)
class Leg:
    end: tuple[float, float]
    left: int


@dataclass(frozen=True, eq=False)
class Diary:
    leg: Leg | None
    legs: tuple[Leg, ...]
    flags: np.ndarray
    weights: np.ndarray
    name: str
    on: bool


legs = st.builds(
    Leg,
    end=st.tuples(st.floats(allow_nan=False), st.floats(allow_nan=False)),
    left=st.integers(),
)


@given(st.none() | legs, st.lists(legs, max_size=3).map(tuple), st.text(), st.booleans())
def test_a_round_trip_gives_the_same_value_and_bytes(leg, many, name, on):
    diary = Diary(leg, many, np.arange(3) > 1, np.arange(6.0).reshape(2, 3).T, name, on)
    data = dumps(diary)
    back = loads(Diary, data)
    assert (back.leg, back.legs, back.name, back.on) == (leg, many, name, on)
    assert np.array_equal(back.flags, diary.flags)
    assert back.flags.dtype == np.bool_
    assert np.array_equal(back.weights, diary.weights)
    assert not back.weights.flags.writeable
    assert dumps(back) == data


def test_none_and_numpy_scalars():
    assert loads(type(None), dumps(None)) is None
    assert loads(Leg, dumps(Leg((np.float64(1.0), 2.0), np.int64(3)))) == Leg((1.0, 2.0), 3)


@pytest.mark.parametrize("value", [[1], {"a": 1}, {1}, object(), np.array(["x"]), 1j])
def test_other_things_are_refused_by_name(value):
    with pytest.raises(TypeError, match="cannot hold"):
        dumps(value)


@given(st.binary(max_size=40))
def test_random_bytes_are_a_value_error(data):
    with pytest.raises(ValueError):  # noqa: PT011
        loads(Leg, b"\x01" + data)


@given(st.data())
def test_broken_bytes_never_raise_anything_else(data):
    good = bytearray(dumps(Diary(Leg((1.0, 2.0), 3), (), np.ones(2), np.ones((2, 2)), "x", True)))
    at = data.draw(st.integers(0, len(good) - 1))
    good[at] = data.draw(st.integers(0, 255))
    cut = data.draw(st.integers(0, len(good)))
    for broken in (bytes(good), bytes(good[:cut])):
        with contextlib.suppress(ValueError):
            loads(Diary, broken)


def test_the_wrong_kind_is_named():
    with pytest.raises(ValueError, match="Leg"):
        loads(Diary, dumps(Leg((0.0, 0.0), 1)))
