import pytest
import zenoh
from hypothesis import given
from hypothesis import strategies as st

from uavbridge.bus.matching import check, intersects

CHUNKS = [
    "a", "b", "ab", "@a", "@", "*", "**", "$*", "a$*", "$*b", "a$*b", "$*a$*", "@$*", "a@$*",
    "$*$*", "", "a*", "$", "a#", "?",
]  # fmt: skip
expressions = st.lists(st.sampled_from(CHUNKS), min_size=1, max_size=4).map("/".join)


def known_to_zenoh(expression: str) -> bool:
    try:
        zenoh.KeyExpr(expression)
    except zenoh.ZError:
        return False
    return True


def known_to_us(expression: str) -> bool:
    try:
        return check(expression) == expression
    except ValueError:
        return False


valid = expressions.filter(known_to_us)


@given(expressions)
def test_the_same_expressions_are_well_formed_as_in_zenoh(expression: str) -> None:
    assert known_to_us(expression) == known_to_zenoh(expression)


@given(valid, valid)
def test_the_same_expressions_meet_as_in_zenoh(one: str, other: str) -> None:
    assert intersects(one, other) == zenoh.KeyExpr(one).intersects(other)
    assert intersects(one, other) == intersects(other, one)


@pytest.mark.parametrize(
    ("pattern", "key", "matches"),
    [
        ("air/**", "air", True),
        ("air/*/*/3", "air/-1/0/3", True),
        ("air/*/3", "air/-1/0/3", False),
        ("state/*/map", "state/12/map", True),
        ("state/1$*", "state/12", True),
        ("**", "@adm/x", False),
    ],
)
def test_examples(pattern: str, key: str, matches: bool) -> None:
    assert intersects(pattern, key) is matches
