from hypothesis import given
from hypothesis import strategies as st

from uavbridge.thinned import keep


@given(st.integers(0, 500), st.integers(2, 40))
def test_first_and_last_stay_in_order_within_the_limit(count, most):
    items = []
    for number in range(count):
        keep(items, number, most)
    assert len(items) <= most
    assert items == sorted(items)
    if count:
        assert (items[0], items[-1]) == (0, count - 1)
    assert count > most or items == list(range(count))
