"""Place agents and copies: who is asked, what it costs, what a failure costs, what comes back."""

from collections import Counter

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from planners.grid import Grid
from planners.pheromone.keeper import Box, Keeper, KeeperLaw
from planners.pheromone.words import ASK, OBSTACLE, PATH, TARGET, decode_local, encode_query
from planners.types import Ask, Edit, FlyVelocity, Goal
from uavbridge.bus.air import Air
from uavbridge.bus.local import LocalHub
from uavbridge.bus.tiles import Tiling
from uavbridge.bus.wire import KEYFRAME, Frame
from uavbridge.config.pheromones import Failure
from uavbridge.errors import ConfigError
from uavbridge.place import trailer
from uavbridge.place.agent import PlaceAgent, Site
from uavbridge.place.channel import PlaceAir
from uavbridge.place.host import PlaceHost
from uavbridge.place.service import Asking, Copies, word_of
from uavbridge.place.store import Store
from uavbridge.place.wire import Said, decode_said, encode_said
from uavbridge.radio import Quality, Radio

GRID = Grid(0.0, 0.0, 10.0, 20, 16)
LAW = KeeperLaw(period=30)
SECOND = 1_000_000
BOXES = {
    1001: Box(0, 0, 10, 8),
    1002: Box(10, 0, 20, 8),
    1003: Box(0, 8, 10, 16),
    1004: Box(10, 8, 20, 16),
}


def centre(box):
    return (box.west + box.east) * 5.0, (box.south + box.north) * 5.0, 2.0


SITES = tuple(Site(place, box, centre(box)) for place, box in BOXES.items())


def goal_at(cell, *, obstacles=(), targets=(), asks=True):
    edits = [Edit(PATH, np.array([cell]), np.ones(1))]
    for layer, cells in ((OBSTACLE, obstacles), (TARGET, targets)):
        if cells:
            edits.append(Edit(layer, np.array(cells), np.ones(len(cells))))
    query = (Ask(ASK, encode_query(cell, 4)),) if asks else ()
    return Goal(FlyVelocity(), edits=tuple(edits), asks=query)


class World:
    """UAVs and place agents on one local bus, a step a second."""

    def __init__(self, uavs=(1, 2), range_m=1000.0, failures=(), store=None, **quality):
        hub, radio = LocalHub(), Radio(range_m, 3, Quality(**quality))
        self.air = Air(hub.bus(), radio, uavs)
        place_air = PlaceAir(hub.bus(), radio, uavs, Tiling(), tick_us=SECOND)
        place_air.share(self.air)
        self.asking = Asking(SITES, place_air)
        self.radio = PlaceAir(hub.bus(), radio, list(BOXES), Tiling(), tick_us=SECOND)
        self.places = PlaceHost(
            SITES, list(BOXES), grid=GRID, law=LAW, step_us=SECOND, before=0, bus=hub.bus(),
            air=self.radio, store=store, failures=failures,
        )  # fmt: skip
        self.t_us = 0

    def step(self, goals, where):
        """One second; the answers that came, decoded, by UAV."""
        told = self.advance(goals, where)
        return {uav: [decode_local(one.data) for one in lot] for uav, lot in told.items()}

    def advance(self, goals, where):
        """One second; the answers that came, by UAV."""
        self.t_us += SECOND
        received = self.asking.receive(where, {}, self.t_us)
        for uav, goal in goals.items():
            self.asking.wish(uav, goal, self.t_us // SECOND, where[uav], self.t_us)
        self.places.step(self.t_us)
        return received

    def whole(self):
        """The path map that the tiles make together."""
        path = np.full(GRID.shape, np.nan)
        for agent in self.places.places.values():
            if agent is not None:
                path[agent.site.tile.slices] = agent.keeper.field.path[agent.site.tile.slices]
        return path


def over(cell, height=40.0):
    return (*GRID.centre_of(cell).tolist(), height)


def test_the_nearest_place_agent_answers_and_the_radio_is_charged():
    world = World()
    where = {1: over((3, 3)), 2: over((15, 12))}
    goals = {uav: goal_at(tuple(GRID.cell_of(place).tolist())) for uav, place in where.items()}
    world.step(goals, where)
    answers = world.step({}, where)
    assert {uav: [local.cell for local in told] for uav, told in answers.items()} == {
        1: [(3, 3)],
        2: [(15, 12)],
    }
    sent = {place: traffic.frames_sent for place, traffic in world.radio.traffic.items()}
    assert sent == {1001: 1, 1002: 0, 1003: 0, 1004: 1}
    for uav in (1, 2):
        traffic = world.air.traffic[uav]
        assert (traffic.frames_sent, traffic.frames_heard) == (1, 1)
        assert traffic.bytes_heard > 500
    assert sum(world.places.net_bytes.values()) > 0


def test_tiles_and_one_map_are_the_same_through_the_bus():
    world, one = World(), Keeper(GRID.shape, LAW)
    draw = np.random.default_rng(4)
    before = {}
    for number in range(1, 40):
        cells = {uav: tuple(draw.integers(0, (20, 16)).tolist()) for uav in (1, 2)}
        stones = [tuple(draw.integers(0, (20, 16)).tolist())] if number % 7 == 0 else []
        goals = {uav: goal_at(cell, obstacles=stones) for uav, cell in cells.items()}
        where = {uav: over(cell) for uav, cell in cells.items()}
        told = world.step(goals, where)
        for uav, locals_ in told.items():
            expected = one.local(before[uav], 4)
            (local,) = locals_
            np.testing.assert_allclose(local.path[local.known], expected.path[local.known])
            np.testing.assert_allclose(local.obstacle, expected.obstacle, atol=1e-6)
            assert local.known.sum() == expected.known.sum()
        for uav, goal in goals.items():
            one.hear(uav, word_of(goal, number))
        one.update()
        before = cells
    np.testing.assert_allclose(world.whole(), one.field.path)


def test_out_of_range_nobody_answers():
    world = World(range_m=60.0)
    where = {1: over((0, 0), 100.0), 2: over((5, 4))}
    world.step({1: goal_at((0, 0)), 2: goal_at((5, 4))}, where)
    assert set(world.step({}, where)) == {2}
    assert world.air.traffic[1].frames_sent == 0


def asked(world, seconds, where):
    """A UAV asks every second; for each answer when it came, and how old it was."""
    came = []
    for second in range(seconds):
        told = world.advance({1: goal_at((3, 3))}, {1: where, 2: over((15, 12))})
        came += [(second, answer.age_s) for answer in told.get(1, [])]
    return came


def test_words_and_answers_are_lost_as_the_radio_says():
    world = World(loss=0.3)
    came = asked(world, 300, over((3, 3)))
    lost = world.air.traffic[1].dropped["loss"]
    heard = sum(traffic.frames_heard for traffic in world.radio.traffic.values())
    assert 0.6 < heard / world.air.traffic[1].frames_sent < 0.8
    assert lost + len(came) in (heard, heard - 1)
    assert 0.6 < len(came) / heard < 0.8


def test_a_burst_takes_all_words_of_its_ticks():
    world = World(burst_enter=0.05, burst_leave=0.1)
    came = [second for second, _ in asked(world, 400, over((3, 3)))]
    gaps = np.diff(came) - 1
    assert gaps.max() >= 5, "ticks without an answer come together"


def test_words_and_answers_take_their_time():
    came = asked(World(delay_s=1.5), 20, over((3, 3)))
    assert came[0][0] == 4  # 1.5 s there, seen at the next step, and 1.5 s back
    assert {age for _, age in came} == {2.0}


def test_bandwidth_is_shared_with_frames_and_waiting_is_charged():
    free, busy = World(bytes_per_s=5000.0), World(bytes_per_s=5000.0)
    for world, load in ((free, 0), (busy, 6000)):
        world.air.send(Frame(KEYFRAME, 1, 0, SECOND, over((3, 3)), (0.0,) * 3, bytes(load), 0, b""))
    assert asked(free, 6, over((3, 3)))[0][0] < asked(busy, 6, over((3, 3)))[0][0]
    narrow = World(bytes_per_s=100.0, queue_s=1.0)  # an answer has 600 bytes
    assert min(age for _, age in asked(narrow, 20, over((3, 3)))) > 6.0
    assert sum(traffic.dropped["queue"] for traffic in narrow.radio.traffic.values()) > 0


@pytest.mark.parametrize("kept", ["store", "neighbours"])
def test_a_failure_costs_one_tile_and_it_comes_back(kept):
    store = {} if kept == "store" else None
    failure = Failure(place=1001, from_s=25.0, to_s=45.0)
    world = World(failures=(failure,), store=store)
    where = {1: over((3, 3)), 2: over((8, 7))}
    deep, edge = (2, 1), (8, 7)
    for _ in range(24):
        world.step({1: goal_at(deep), 2: goal_at(edge)}, where)
    assert world.whole()[deep] == pytest.approx(0.1)
    answered = Counter()
    for _ in range(20):
        for uav in world.step({1: goal_at((12, 3)), 2: goal_at((12, 12))}, where):
            answered[uav] += 1
    path = world.whole()
    assert np.isnan(path[BOXES[1001].slices]).all(), "its tile is lost"
    assert path[12, 3] == pytest.approx(0.1), "the others go on"
    assert answered[1] > 10, "another one answers"
    for _ in range(4):
        world.step({}, where)
    path = world.whole()
    assert not np.isnan(path).any()
    assert path[edge] == pytest.approx(0.1), "what lies along the border came from the neighbours"
    assert path[deep] == pytest.approx(0.1 if kept == "store" else 2.0)


def test_marks_signal_after_the_period_and_survive_in_a_store(tmp_path):
    store = Store(tmp_path / "tiles")
    world = World(store=store)
    where = {1: over((5, 4)), 2: over((15, 4))}
    world.step({1: goal_at((5, 4), targets=[(5, 4)])}, where)
    for _ in range(11):
        world.step({}, where)
    assert set(store) == set(BOXES)
    again = World(store=Store(tmp_path / "tiles"))
    again.t_us = world.t_us
    for _ in range(21):
        again.step({1: goal_at((5, 5))}, where)
    (local,) = again.step({}, where)[1]
    assert (local.marks.tolist(), local.due.tolist()) == ([[5, 4]], [True])
    assert local.target.max() > 0.0


def test_a_store_belongs_to_one_run_and_survives_what_is_no_tile(tmp_path, caplog):
    store = Store(tmp_path / "tiles", run=3)
    store[1001] = b"tile"
    assert dict(Store(tmp_path / "tiles", run=3)) == {1001: b"tile"}
    assert dict(Store(tmp_path / "tiles", run=4)) == {}
    (tmp_path / "tiles" / "place-1001.tile").write_bytes(b"no")
    assert 1001 not in store
    (tmp_path / "tiles" / "place-1002.new").mkdir()
    store[1002] = b"cannot be"
    store[1002] = b"written"
    assert caplog.text.count("not written") == 1
    (tmp_path / "file").touch()
    with pytest.raises(ConfigError, match="--store"):
        Store(tmp_path / "file")


def frame(sender, tick, payload=b""):
    place = (0.0, 0.0, 40.0)
    return Frame(KEYFRAME, sender, tick, tick * SECOND, place, (0.0,) * 3, payload, 0, b"")


def test_copies_are_one_map_when_all_is_heard_and_catch_up_after_a_loss():
    uavs = (1, 2, 3)
    copies = Copies(LocalHub().bus(), uavs, GRID, LAW, SECOND, 0)
    one = Keeper(GRID.shape, LAW)
    draw = np.random.default_rng(2)
    frames = {}
    for tick in range(1, 30):
        lost = tick % 5 == 0
        copies.receive(
            {}, {u: [] if lost else [frames[s] for s in frames if s != u] for u in uavs}, 0
        )
        cells = {uav: tuple(draw.integers(0, (20, 16)).tolist()) for uav in uavs}
        for uav, cell in cells.items():
            goal = goal_at(cell)
            copies.wish(uav, goal, tick, (0.0,) * 3, tick * SECOND)
            one.hear(uav, word_of(goal, tick))
        frames = {uav: copies.outgoing(frame(uav, tick, b"own")) for uav in uavs}
        copies.step(tick * SECOND)
        one.update()
    answers = copies.receive({}, {u: [frames[s] for s in frames if s != u] for u in uavs}, 0)
    copies.step(30 * SECOND)
    one.update()
    assert trailer.own(frames[1].payload) == b"own"
    for keeper in copies.keepers.values():
        np.testing.assert_allclose(keeper.field.path, one.field.path)
    assert {uav: decode_local(told[-1].data).cell for uav, told in answers.items()} == cells


@given(st.binary(max_size=40), st.lists(st.binary(max_size=60), max_size=4))
def test_trailers_come_apart_again(payload, said):
    whole = trailer.joined(payload, said)
    assert trailer.own(whole) == payload
    assert trailer.words(whole) == said


@given(st.binary(max_size=80))
def test_payloads_without_a_trailer_are_whole(payload):
    if payload[-2:] != b"\xf0\x9c":
        assert trailer.own(payload) == payload
        assert trailer.words(payload) == []


@given(st.binary(max_size=60))
def test_nonsense_is_counted_never_raised(data):
    rejects = Counter()
    if decode_said(data, rejects) is None:
        assert sum(rejects.values()) == 1
    said = Said(3, 1001, 5, (1.0, 2.0, 3.0), data)
    assert decode_said(encode_said(said)) == said
    agent = PlaceAgent(SITES[0], {1002: BOXES[1002]}, GRID.shape, LAW)
    before = agent.rejected
    agent.heard(1, data)
    agent.told(data)
    assert agent.rejected - before == 2
