import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from planners.hashing import mixed, mixed_one


@given(st.lists(st.integers(0, 2**64 - 1), min_size=1))
def test_one_by_one_is_as_all_at_once(values):
    assert mixed(np.array(values, np.uint64)).tolist() == [mixed_one(value) for value in values]


def test_it_is_splitmix64():
    # the first outputs of the reference implementation for the seed 0
    step = 0x9E3779B97F4A7C15
    expected = [0xE220A8397B1DCDAF, 0x6E789E6AA1B965F4, 0x06C45D188009454F]
    assert [mixed_one(k * step) for k in range(3)] == expected
