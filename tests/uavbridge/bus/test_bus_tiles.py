import math

from hypothesis import given
from hypothesis import strategies as st

from uavbridge.bus import keys
from uavbridge.bus.listening import MOST_TILES, Listening
from uavbridge.bus.local import LocalHub
from uavbridge.bus.tiles import Tiling

spots = st.tuples(*[st.floats(-5e3, 5e3)] * 2, st.floats(0, 100))


@given(spots, spots, st.floats(0, 2000), st.floats(0.1, 30))
def test_who_is_in_range_is_in_a_subscribed_tile(
    here: tuple[float, ...], there: tuple[float, ...], range_m: float, speed: float
) -> None:
    tiling = Tiling.of(range_m, speed)
    tiles = tiling.around([here])
    assert tiling.tile_of(here) in tiles
    if math.hypot(here[0] - there[0], here[1] - there[1]) <= range_m + 4 * speed:
        assert tiling.tile_of(there) in tiles
    wider = tiling.around([here], tiling.leave_m)
    assert tiles <= wider
    assert len(wider) <= 16


@given(st.floats(0, 2000), st.floats(0.1, 30))
def test_tiles_are_as_wide_as_a_link_and_some_seconds_of_flight(range_m: float, v: float) -> None:
    assert Tiling.of(range_m, v).width_m >= range_m + 4 * v


def test_an_unlimited_range_has_one_tile() -> None:
    tiling = Tiling.of(float("inf"), 10.0)
    assert tiling.tile_of((1e5, -1e5, 0.0)) == (0, 0)
    assert tiling.around([(1e5, -1e5, 0.0)]) == {(0, 0)}


def test_many_agents_far_apart_share_one_subscription_and_near_ones_few() -> None:
    bus, tiling = LocalHub().bus(), Tiling.of(100.0, 10.0)
    listening = Listening(bus, keys.air, tiling)
    assert listening.subscriptions == 1
    listening.follow([(0.0, 0.0)])
    assert 4 <= listening.subscriptions <= MOST_TILES
    listening.follow([(1000.0 * i, 0.0) for i in range(20)])
    assert listening.subscriptions == 1
    listening.follow([(0.0, 0.0), (10.0, 0.0)])
    assert 4 <= listening.subscriptions <= MOST_TILES


def test_standing_at_an_edge_changes_no_subscription() -> None:
    hub = LocalHub()
    listening = Listening(hub.bus(), keys.air, Tiling.of(100.0, 10.0))
    listening.follow([(-1.0, 0.0)])
    listening.follow([(1.0, 0.0)])
    before = list(hub.mailboxes)
    for x in (-1.0, 1.0, -2.0, 2.0):
        listening.follow([(x, 0.0)])
    assert hub.mailboxes == before
    listening.follow([(300.0, 0.0)])
    assert hub.mailboxes != before
    listening.close()
    assert hub.mailboxes == []
